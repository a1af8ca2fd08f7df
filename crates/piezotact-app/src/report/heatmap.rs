//! A height map as an image.
