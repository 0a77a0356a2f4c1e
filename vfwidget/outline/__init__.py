"""The shape of letters, without files: cubic contours and their variation (Eq. 1–2)."""
