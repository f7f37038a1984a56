#pragma once

#include "haptics/tuning/TuningReadings.h"
#include "samples/shared/shards/LineJournal.h"

#include <complex>
#include <string>

namespace midair::samples
{

/// The file of readings while they are taken: each is appended when it is there, and what a run
/// left behind is continued by the next.
class ReadingJournal
{
public:
    /// Opens \a path, or begins it. Throws base::InputError if another run has it, if it belongs to
    /// another plan, or can't be read or written.
    ReadingJournal(const std::string& path,
                   const haptics::TuningPlan& plan,
                   const std::string& planSum);

    /// What there is of each row; rows without a number are to be read.
    const haptics::TuningReadings& found() const { return _found; }
    bool isRead(int row) const;

    /// Appends a reading; it survives a kill at once, and a failing power supply after half a
    /// second. Throws base::InputError if it can't be written.
    void append(int row, std::complex<double> value, bool isLevel);

    /// Takes the readings of \a place out, so that it is read anew; the file as it was stays as
    /// PATH.old.
    void forget(int place);

private:
    void write(const std::string& text);

    const std::string _path;
    const haptics::TuningPlan& _plan;
    const std::string _sum;
    LineJournal _file;
    haptics::TuningReadings _found;
    double _synced_s = 0.0;
};

} // namespace midair::samples
