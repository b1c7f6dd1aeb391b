//! Tests of spindles' files: catalogue, keys, mistakes, doubts.

mod catalogue;
mod doubts;
mod monitor_keys;
mod preload;
mod wrong_files;
