"""One file a revision, in order of the number that its name begins with."""
