"""What the studies share: walks, processes, recorders, models, pictures, pages, files."""
