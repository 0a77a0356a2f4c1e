"""Letters that overlap each other or artwork: exact areas, contacts, and how to resolve them."""
