//! Tests of the audio crate as others use it.

mod force;
