"""What an SVG draws, read as browsers do: a tree of shapes, their styles, paths and strokes."""
