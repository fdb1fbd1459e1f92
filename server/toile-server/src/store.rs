//! The outfits that the service knows: a row in SQLite for each, beside the file as it was uploaded.

use std::collections::HashSet;
use std::time::Duration;

use serde::{Deserialize, Serialize};
use sqlx::Row;
use sqlx::migrate::Migrator;
use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePool, SqlitePoolOptions, SqliteRow};
use thiserror::Error;
use toile_drape::hero::{self, Hero};
use toile_drape::outfit::{Outfit, Report};
use tokio::sync::Mutex;

use crate::files::{DataDir, remove_if_present, sweep, write_atomically};
use crate::upload::Upload;

static MIGRATIONS: Migrator = sqlx::migrate!("../../migrations");
/// How long to wait for another process that writes to the same database.
const BUSY_TIMEOUT: Duration = Duration::from_secs(10);
const COLUMNS: &str = "sequence, id, name, created_at, upload, summary, report";

/// Why the store failed. Never the client's fault.
#[derive(Debug, Error)]
pub enum StoreError {
    /// The database.
    #[error("database: {0}")]
    Database(#[from] sqlx::Error),
    /// Its schema.
    #[error("database schema: {0}")]
    Migration(#[from] sqlx::migrate::MigrateError),
    /// A file of the data directory.
    #[error("data directory: {0}")]
    File(#[from] std::io::Error),
    /// A JSON column.
    #[error("stored JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// A task that was cut off.
    #[error("background task: {0}")]
    Task(#[from] tokio::task::JoinError),
}

/// Counts of one garment.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq, Serialize)]
pub struct GarmentSummary {
    /// Unique within the outfit.
    pub name: String,
    /// Welded vertices.
    pub vertices: usize,
    /// Triangles.
    pub triangles: usize,
    /// 0 is next to the skin.
    pub layer: u32,
    /// Whether there is a pixel-cloth network of it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub pixel_cloth: bool,
}

/// Counts of an outfit.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq, Serialize)]
pub struct Summary {
    /// Welded vertices.
    pub vertices: usize,
    /// Triangles.
    pub triangles: usize,
    /// Innermost first.
    pub garments: Vec<GarmentSummary>,
}

impl Summary {
    /// Counts of `outfit`, and which of its garments are `heroes`.
    pub fn of(outfit: &Outfit, heroes: &[Hero]) -> Self {
        let known = hero::known(&heroes.iter().collect::<Vec<_>>(), outfit);
        let garments = outfit.garments.iter().zip(known).map(|(garment, pixel_cloth)| GarmentSummary {
            pixel_cloth,
            name: garment.name.clone(),
            vertices: garment.vertices.len(),
            triangles: garment.triangles().len(),
            layer: garment.layer,
        });
        Self {
            vertices: outfit.positions.len(),
            triangles: outfit.triangles.len(),
            garments: garments.collect(),
        }
    }
}

/// An outfit that is about to be kept.
#[derive(Clone, Debug)]
pub struct NewOutfit {
    /// Content hash.
    pub id: String,
    /// For people.
    pub name: String,
    /// How to read the file again.
    pub upload: Upload,
    /// Counts.
    pub summary: Summary,
    /// What was found and mended.
    pub report: Report,
}

/// An outfit as kept.
#[derive(Clone, Debug)]
pub struct StoredOutfit {
    /// Place in the listing.
    pub sequence: i64,
    /// RFC 3339, UTC.
    pub created_at: String,
    /// Everything that was kept.
    pub outfit: NewOutfit,
}

/// Rows and files of outfits. Cheap to clone.
#[derive(Clone)]
pub struct Store {
    pool: SqlitePool,
    data: DataDir,
    /// Keeps and deletes touch a row and files: one at a time within this process.
    changes: std::sync::Arc<Mutex<()>>,
}

impl Store {
    /// Opens the database of a data directory and brings its schema up to date.
    ///
    /// # Errors
    /// When the database cannot be opened or migrated.
    pub async fn open(data: DataDir) -> Result<Self, StoreError> {
        let options = SqliteConnectOptions::new()
            .filename(data.database())
            .create_if_missing(true)
            .journal_mode(SqliteJournalMode::Wal)
            .foreign_keys(true)
            .busy_timeout(BUSY_TIMEOUT);
        let pool = SqlitePoolOptions::new().max_connections(4).connect_with(options).await?;
        MIGRATIONS.run(&pool).await?;
        Ok(Self { pool, data, changes: std::sync::Arc::default() })
    }

    /// The data directory.
    pub fn data(&self) -> &DataDir {
        &self.data
    }

    /// Keeps an outfit: the file first, the row last, so that a row never lacks its file.
    /// Keeping the same outfit again changes nothing. Returns whether it is new.
    ///
    /// # Errors
    /// When file or row cannot be written; nothing is left behind then.
    pub async fn keep(&self, new: NewOutfit, file: bytes::Bytes) -> Result<bool, StoreError> {
        let _turn = self.changes.lock().await;
        if self.get(&new.id).await?.is_some() {
            return Ok(false);
        }
        let path = self.data.outfit(&new.id);
        let written = path.clone();
        tokio::task::spawn_blocking(move || write_atomically(&written, &file)).await??;
        let inserted = self.insert(&new).await;
        if inserted.is_err() {
            remove_if_present(&path)?;
        }
        inserted
    }

    async fn insert(&self, new: &NewOutfit) -> Result<bool, StoreError> {
        let insert = "INSERT INTO outfits (id, name, upload, summary, report) VALUES (?, ?, ?, ?, ?) \
                      ON CONFLICT (id) DO NOTHING";
        let done = sqlx::query(insert)
            .bind(&new.id)
            .bind(&new.name)
            .bind(serde_json::to_string(&new.upload)?)
            .bind(serde_json::to_string(&new.summary)?)
            .bind(serde_json::to_string(&new.report)?)
            .execute(&self.pool)
            .await?;
        Ok(done.rows_affected() == 1)
    }

    /// The outfit of this id.
    ///
    /// # Errors
    /// When the database fails.
    pub async fn get(&self, id: &str) -> Result<Option<StoredOutfit>, StoreError> {
        let query = sqlx::query(sqlx::AssertSqlSafe(format!("SELECT {COLUMNS} FROM outfits WHERE id = ?")));
        let row = query.bind(id).fetch_optional(&self.pool).await?;
        row.as_ref().map(from_row).transpose()
    }

    /// Up to `limit` outfits after the one at `sequence`, oldest first.
    ///
    /// # Errors
    /// When the database fails.
    pub async fn list(&self, after: i64, limit: i64) -> Result<Vec<StoredOutfit>, StoreError> {
        let text = format!("SELECT {COLUMNS} FROM outfits WHERE sequence > ? ORDER BY sequence LIMIT ?");
        let query = sqlx::query(sqlx::AssertSqlSafe(text)).bind(after).bind(limit);
        query.fetch_all(&self.pool).await?.iter().map(from_row).collect()
    }

    /// Removes an outfit with all its files. Returns whether there was one.
    ///
    /// # Errors
    /// When the row or a file cannot be removed.
    pub async fn delete(&self, id: &str, static_key: &str) -> Result<bool, StoreError> {
        let _turn = self.changes.lock().await;
        let done = sqlx::query("DELETE FROM outfits WHERE id = ?").bind(id).execute(&self.pool).await?;
        if done.rows_affected() == 0 {
            return Ok(false);
        }
        let (data, key) = (&self.data, static_key);
        let own = [data.outfit(id), data.static_pass(key), data.bake(key), data.hero(id), data.thumbnail(id)];
        for path in own {
            remove_if_present(&path)?;
        }
        Ok(true)
    }

    /// Removes files that no row refers to. `key_of` tells the static pass that belongs to an outfit.
    ///
    /// # Errors
    /// When the database or a folder cannot be read.
    pub async fn sweep(&self, key_of: impl Fn(&str) -> String) -> Result<usize, StoreError> {
        let rows = sqlx::query("SELECT id FROM outfits").fetch_all(&self.pool).await?;
        let ids = rows.iter().map(|row| row.try_get(0)).collect::<Result<HashSet<String>, _>>()?;
        let keys: HashSet<String> = ids.iter().map(|id| key_of(id)).collect();
        let outfits = sweep(&self.data.outfits(), |name| ids.contains(name))?;
        let statics = sweep(&self.data.statics(), |name| keys.contains(name))?;
        let bakes = sweep(&self.data.bakes(), |name| keys.contains(name))?;
        let heroes = sweep(&self.data.heroes(), |name| ids.contains(name))?;
        let is_picture = |name: &str| name.strip_suffix(".png").is_some_and(|id| ids.contains(id));
        Ok(outfits + statics + bakes + heroes + sweep(&self.data.thumbnails(), is_picture)?)
    }

    /// Which outfit a file of the shipped gallery became when it was last loaded.
    ///
    /// # Errors
    /// When the database fails.
    pub async fn gallery_outfit(&self, file: &str) -> Result<Option<String>, StoreError> {
        let query = sqlx::query("SELECT outfit FROM gallery WHERE file = ?").bind(file);
        Ok(query.fetch_optional(&self.pool).await?.map(|row| row.try_get(0)).transpose()?)
    }

    /// Remembers which outfit a file of the shipped gallery became.
    ///
    /// # Errors
    /// When the database fails.
    pub async fn remember_gallery_outfit(&self, file: &str, outfit: &str) -> Result<(), StoreError> {
        let upsert = "INSERT INTO gallery (file, outfit) VALUES (?, ?) \
                      ON CONFLICT (file) DO UPDATE SET outfit = excluded.outfit";
        sqlx::query(upsert).bind(file).bind(outfit).execute(&self.pool).await?;
        Ok(())
    }

    /// Closes the database, so that the write-ahead log is folded in.
    pub async fn close(&self) {
        self.pool.close().await;
    }
}

fn from_row(row: &SqliteRow) -> Result<StoredOutfit, StoreError> {
    let json = |column: &str| row.try_get::<String, _>(column);
    let outfit = NewOutfit {
        id: row.try_get("id")?,
        name: row.try_get("name")?,
        upload: serde_json::from_str(&json("upload")?)?,
        summary: serde_json::from_str(&json("summary")?)?,
        report: serde_json::from_str(&json("report")?)?,
    };
    Ok(StoredOutfit { sequence: row.try_get("sequence")?, created_at: row.try_get("created_at")?, outfit })
}
