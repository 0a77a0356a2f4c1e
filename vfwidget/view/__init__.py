"""The notebook widgets, and what they send to the browser."""
