//! From radiance to grey values.
