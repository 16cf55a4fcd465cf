"""Worker processes of one thread each, that may hang or die."""
