"""HTTP: routers, wire schemas, dependencies and the error table."""
