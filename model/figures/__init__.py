"""Pictures of docs/deepsd.md, drawn from what ships."""
