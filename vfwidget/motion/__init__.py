"""Text in motion: animations, and the simulation that makes them (Sec. 5.3)."""
