"""How the package is built: the backend, the C compiler and the extension module. Not installed."""
