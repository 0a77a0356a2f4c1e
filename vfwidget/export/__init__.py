"""Files for other programs, written from plain data: outlines, axis values, times."""
