"""Problems with known answers for the least-squares solver; see :mod:`.nist` and :mod:`.mgh`."""
