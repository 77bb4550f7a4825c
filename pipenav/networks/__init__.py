"""Maps of pipe networks, as operators have them in files: thousands of pipes, and where each number came from."""

from pipenav.networks.checks import is_sketch, map_notes
from pipenav.networks.fields import DiameterField, ReadOptions
from pipenav.networks.model import NetworkMap, Note, Origin
from pipenav.networks.reader import ENDINGS, read_network_map

__all__ = [
    "ENDINGS",
    "DiameterField",
    "NetworkMap",
    "Note",
    "Origin",
    "ReadOptions",
    "is_sketch",
    "map_notes",
    "read_network_map",
]
