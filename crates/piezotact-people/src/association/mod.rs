//! Association matrices: which presented texture was answered as which.
