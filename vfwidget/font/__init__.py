"""A font file in, dense tensors out: the only place that knows OpenType tables."""

from ..outline.glyph import Glyph
from .axes import Axis, NamedInstance
from .font import Font, load_font
from .source import bundled_fonts

__all__ = ["Axis", "Font", "Glyph", "NamedInstance", "bundled_fonts", "load_font"]
