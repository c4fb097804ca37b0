//! Lane maths, written once for every width.
