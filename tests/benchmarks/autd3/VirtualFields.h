#pragma once

/// Prints what becomes of fields in virtual time, of \a duration_s each, on \a units units; \a loss
/// of the datagrams where some are lost.
void playVirtualFields(int units, double duration_s, double loss);
