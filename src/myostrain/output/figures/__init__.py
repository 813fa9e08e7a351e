"""Pictures of result folders, one kind a file."""
