"""Water on the windshield, and the wiper."""
