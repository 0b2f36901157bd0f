"""The version of this package, sent in the handshake."""

VERSION = "0.1.0"
