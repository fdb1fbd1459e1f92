"""Generated outfits: garments as trimmed level sets around the reference body."""
