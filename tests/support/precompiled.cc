// Holds the precompiled headers of the tests; has nothing to say itself.
