"""Files of a scene and its results together: fields on the elements for ParaView."""

from flankload.export.fields import write_vtu

__all__ = ["write_vtu"]
