"""The camera for hours while everything around it fails at random: `./soak`, whose parts `__main__` lists."""
