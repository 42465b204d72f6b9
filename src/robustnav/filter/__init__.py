"""The readable NumPy step of each filter: the specification the compiled filters are held to."""
