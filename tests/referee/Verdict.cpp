#include "tests/referee/Verdict.h"

#include <algorithm>
#include <cmath>

namespace midair::referee
{

const std::set<std::string> kNotRecomputed = {"iterations", "matrix_ms", "solve_ms"};

// A pressure sums m products, and an entry of G is within 7e-5 of itself (PropagationKernels.h):
// errors that are independent leave 7e-5 sqrt(n/m)/E of the pressure, 1.1e-5 at n = 100. Measured
// over a thousand updates: up to 2.0e-5 of one pressure, and 1.2e-6 of an rms below 2e-4, in which
// they average out. So one error counts as true within 4e-5, an rms within 2e-6: smaller ones are
// not told apart from single precision; where n/m is larger than there, in proportion to its root.
// A phase's step is within 2e-7 rad a transducer (compareDrives), and a change within 1e-7 of its
// root.
double floorOf(const std::string& figure, int points, int transducers)
{
    static const std::set<std::string> kOfPressures = {
        "rms", "max", "rmsOfLargest", "maxOfLargest", "worstShortfall"};
    constexpr double kUsual = 100.0 / 3984.0; // points a transducer
    const double crowd =
        std::sqrt(std::max(1.0, static_cast<double>(points) / transducers / kUsual));
    static const std::map<std::string, double> kFloors = {{"rms", 2e-4},
                                                          {"max", 4e-3},
                                                          {"rmsOfLargest", 2e-4},
                                                          {"maxOfLargest", 4e-3},
                                                          {"worstShortfall", 4e-3},
                                                          {"meanPhaseStep_rad", 2e-5},
                                                          {"driveChange", 1e-8},
                                                          {"audibleChange", 1e-8}};
    const auto found = kFloors.find(figure);
    if (found == kFloors.end()) return 1e-12;
    return found->second * (kOfPressures.count(figure) > 0 ? crowd : 1.0);
}

namespace
{

// \a floor: of floorOf().
void compare(
    const std::string& name, double told, const Truth& truth, double floor, Verdict& verdict)
{
    const double nearest = std::clamp(told, truth.least, truth.most);
    // Written so that NaN is off.
    const double off = std::fabs(told - nearest) / std::max(std::fabs(nearest), floor);
    Worst& worst = verdict.figures[name];
    if (!(off <= (truth.isCount ? 0.0 : kMostOff))) ++worst.failures;
    worst.apart = std::max(worst.apart, std::fabs(told - nearest));
    if (off <= worst.off) return;
    worst.off = off;
    worst.told = told;
    worst.truth = nearest;
    worst.update = verdict.updates;
}

void compareAll(const Update& update, const Recomputed& truth, int transducers, Verdict& verdict)
{
    int points = 0; // of the field that has most
    for (const Part& part : update.parts)
        points = std::max(points, part.points.size());
    for (const auto& [name, told] : haptics::figuresOf(update.report))
    {
        const auto found = truth.figures.find(name);
        if (found != truth.figures.end())
            compare(name, told, found->second, floorOf(name, points, transducers), verdict);
        else if (kNotRecomputed.count(name) == 0)
            verdict.missing.insert(name);
    }
}

void measureSkipping(const Update& update, const Recomputed& truth, Verdict& verdict)
{
    if (update.isRepeat || update.report.stop == haptics::StopReason::SKIPPED) ++verdict.skipped;
    if (truth.worstMove_m == 0.0) return;
    verdict.worstMove_m = std::max(verdict.worstMove_m, truth.worstMove_m);
    verdict.rmsAsked = std::max(verdict.rmsAsked, truth.rmsAsked);
    verdict.rmsAdded = std::max(verdict.rmsAdded, truth.rmsAsked - update.report.rms);
}

} // namespace

int Verdict::failures() const
{
    int sum = 0;
    for (const auto& [name, worst] : figures)
        sum += worst.failures;
    return sum;
}

bool Verdict::passed() const
{
    return failures() == 0 && missing.empty() && updates > 0 && rmsAdded <= mostAdded &&
           overCap <= 1.0 + 1e-5;
}

Verdict judge(const Recorded& recorded)
{
    Verdict verdict;
    Recomputer recomputer(recorded);
    verdict.mostAdded = 2.0 * M_PI * recorded.skipTolerance_m /
                        recorded.medium.wavelength(recorded.array.frequency_Hz);
    for (const Update& update : recorded.updates)
    {
        const Recomputed truth = recomputer.next();
        measureSkipping(update, truth, verdict);
        if (!update.isRepeat) compareAll(update, truth, recorded.array.size(), verdict);
        ++verdict.updates;
        if (recorded.cap_Pa > 0.0)
            verdict.overCap = std::max(verdict.overCap, truth.loudest_Pa / recorded.cap_Pa);
    }
    return verdict;
}

} // namespace midair::referee
