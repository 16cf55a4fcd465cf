"""What a Python program calls, and the command line as well: drive, sweep and report."""
