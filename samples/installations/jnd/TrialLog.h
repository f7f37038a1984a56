#pragma once

#include "samples/installations/jnd/TrialFile.h"
#include "samples/shards/LineJournal.h"

#include <string>

namespace midair::samples
{

/// The file of results while a session goes on: each answer is on the disk before the next trial
/// begins, and a session that died goes on where it was.
class TrialLog
{
public:
    /// Opens \a path to go on with it, or begins it. Throws base::InputError, and leaves the file,
    /// if another run has it, if it holds something else, or another experiment, participant or
    /// setting.
    TrialLog(const std::string& path, const SessionHead& head);

    const TrialFile& results() const { return _results; }
    /// A sentence on what was found and dropped; empty: nothing.
    const std::string& dropped() const { return _dropped; }

    /// Adds the answer to what the staircase asks, with the figures of \a played. Returns when it
    /// is on the disk. Throws base::InputError if it can't be written.
    void add(bool isFelt, const Trial& played);
    /// Adds that the trial which is asked for was played in vain.
    void addVoid(const std::string& why);

private:
    const std::string _path;
    LineJournal _file;
    TrialFile _results;
    std::string _dropped;
};

} // namespace midair::samples
