"""Measurements of the running camera from outside: `./bench`, whose parts `__main__` lists."""
