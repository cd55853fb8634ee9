// The page at /docs: Swagger UI, served from here, over the service's own description.

window.SwaggerUIBundle({
  url: "openapi.json",
  dom_id: "#api",
  deepLinking: true,
  persistAuthorization: false, // a key is forgotten with the page
  validatorUrl: null, // asks nobody elsewhere
});
