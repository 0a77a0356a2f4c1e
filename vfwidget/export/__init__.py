"""Export to files that need no kernel."""
