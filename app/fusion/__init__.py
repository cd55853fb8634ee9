"""The positioning methods, one per paper and our own, behind one interface."""
