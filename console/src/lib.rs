//! oxplow: what a person looks at: verification of a log, status, pictures.
