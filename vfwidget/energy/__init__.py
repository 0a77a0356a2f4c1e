"""Energies over points of a text, and the solve that minimises their sum (Eq. 4, Sec. 5.1)."""
