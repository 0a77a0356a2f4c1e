"""A font file in, dense tensors out: the only place that knows OpenType tables."""

from .axes import Axis, NamedInstance
from .font import Font, load_font
from .glyph import Glyph
from .source import bundled_fonts

__all__ = ["Axis", "Font", "Glyph", "NamedInstance", "bundled_fonts", "load_font"]
