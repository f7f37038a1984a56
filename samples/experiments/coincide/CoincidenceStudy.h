#pragma once

#include "samples/shared/shards/LineJournal.h"

#include <Eigen/Core>

#include <cstdint>
#include <string>
#include <vector>

namespace midair::samples
{

/// One trial: the participant moves a fingertip to a visible ball, or blind to a focus.
struct Reach
{
    bool isFelt = false;
    Eigen::Vector3d place = Eigen::Vector3d::Zero(); ///< of the ball or the focus, m
    Eigen::Vector3d tip = Eigen::Vector3d::Zero();   ///< of the finger, held still, m
};

/// Offset of felt from seen places: the mean of (tip - place) over felt trials minus the mean over
/// seen trials. Errors common to both, of tracker and participant, cancel.
struct Coincidence
{
    Eigen::Vector3d difference = Eigen::Vector3d::Zero();    ///< m, one value per axis
    Eigen::Vector3d standardError = Eigen::Vector3d::Zero(); ///< of difference, m
    int seen = 0;
    int felt = 0;

    std::string text() const; ///< lines for the user
};

/// Both kinds need at least two trials; otherwise difference and error are 0.
Coincidence coincidenceOf(const std::vector<Reach>& reaches);

/// Returns trial \a number, from 0, of a session with \a seed. Each pair has one seen and one felt
/// trial in random order, at random places within \a spread_m of \a middle along each axis. The
/// result depends only on the arguments.
Reach trialOf(int number, std::uint64_t seed, const Eigen::Vector3d& middle, double spread_m);

/// A simulated participant with a known offset, to test the procedure.
struct SimulatedReacher
{
    Eigen::Vector3d offset = Eigen::Vector3d::Zero(); ///< felt less seen, m
    double noise_m = 0.005;                           ///< standard deviation per coordinate
    std::uint64_t seed = 1;

    /// Returns the tip in trial \a number. Both kinds share an error of about 4 mm, which must
    /// cancel.
    Eigen::Vector3d tip(int number, const Reach& trial) const;
};

/// The results file of a session: a header, then a line per trial. A session that was interrupted
/// continues from it.
class ReachLog
{
public:
    /// Opens \a path to continue it, or creates it. \a head is one line that identifies the
    /// session. Throws base::InputError, and keeps the file, if it belongs to another session.
    ReachLog(const std::string& path, const std::string& head);

    const std::vector<Reach>& reaches() const { return _reaches; }
    /// Returns once the trial is on disk. Throws base::InputError if it can't be written.
    void add(const Reach& reach);

private:
    LineJournal _file;
    std::vector<Reach> _reaches;
};

} // namespace midair::samples
