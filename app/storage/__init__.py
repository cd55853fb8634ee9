"""SQL tables and repositories, and the stores of session state."""
