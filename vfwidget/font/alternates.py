"""A feature of one's own in a font: a glyph has alternates, which a text chooses by number."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from fontTools.ttLib import TTFont
from fontTools.ttLib.tables import otTables

ALTERNATES = "vfwd"
"""The tag of the feature; registered ones do not begin with v and f."""


def add_alternates(font: TTFont, alternates: Mapping[str, Sequence[str]]) -> None:
    """Add the feature :data:`ALTERNATES` to a font that has a GSUB table.

    Its value k replaces a glyph by the k-th of its alternates (OpenType, "Alternate substitution
    subtable"). It is applied after all other substitutions, because its lookup is the last one.

    Parameters
    ----------
    font : TTFont
        It is changed.
    alternates : mapping of glyph name to glyph names
    """
    table = font["GSUB"].table
    substitution = otTables.AlternateSubst()
    substitution.alternates = {name: list(names) for name, names in alternates.items()}
    lookup = otTables.Lookup()
    lookup.LookupType, lookup.LookupFlag = 3, 0
    lookup.SubTable, lookup.SubTableCount = [substitution], 1
    feature = otTables.Feature()
    feature.FeatureParams = None
    feature.LookupListIndex, feature.LookupCount = [len(table.LookupList.Lookup)], 1
    record = otTables.FeatureRecord()
    record.FeatureTag, record.Feature = ALTERNATES, feature
    table.LookupList.Lookup.append(lookup)
    index = len(table.FeatureList.FeatureRecord)
    table.FeatureList.FeatureRecord.append(record)
    for entry in table.ScriptList.ScriptRecord:
        languages = [one.LangSys for one in entry.Script.LangSysRecord]
        for language in [entry.Script.DefaultLangSys, *languages]:
            if language is not None:
                language.FeatureIndex.append(index)
