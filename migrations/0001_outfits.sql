-- An outfit is a row here and a file of the same id in the data directory.
-- The row is written last and deleted first, so a file without a row is litter, never an outfit.
CREATE TABLE outfits (
    sequence   INTEGER PRIMARY KEY AUTOINCREMENT, -- listing order, oldest first
    id         TEXT NOT NULL UNIQUE,              -- hash of the uploaded bytes and metadata
    name       TEXT NOT NULL,
    created_at TEXT NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%SZ', 'now')),
    upload     TEXT NOT NULL,                     -- JSON: file format and metadata, enough to read the file again
    summary    TEXT NOT NULL,                     -- JSON: counts and garments
    report     TEXT NOT NULL                      -- JSON: what was found and mended
) STRICT;

-- Which outfit each file of the shipped gallery became. A demo outfit that was deleted stays deleted.
CREATE TABLE gallery (
    file   TEXT PRIMARY KEY,
    outfit TEXT NOT NULL
) STRICT;
