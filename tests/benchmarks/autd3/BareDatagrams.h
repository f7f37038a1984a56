#pragma once

/// Sends \a units heartbeats together every \a beat_s over loopback to a process that answers each,
/// takes the answers before the next ones, for \a duration_s: what no driver can do without.
/// Returns the share of a core that this thread uses.
double bareDatagrams(int units, double beat_s, double duration_s);
