"""What leaves the notebook: pages that need no kernel."""
