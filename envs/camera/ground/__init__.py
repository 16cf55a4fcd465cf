"""The road and the verge: what is painted on them, their grain, kept in patches that go with the camera."""
