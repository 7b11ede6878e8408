"""Scenes as Blender artists build them, by script, for `tests/peers/blender.py`."""
