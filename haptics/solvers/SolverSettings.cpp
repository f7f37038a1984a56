#include "haptics/solvers/SolverSettings.h"

#include "haptics/base/Limits.h"
#include "haptics/base/settings/SettingTable.h"
#include "haptics/base/settings/SettingText.h"

namespace midair::base
{

template struct Setting<haptics::SolverSettings>;
template bool isSame(const Member<haptics::SolverSettings>&,
                     const haptics::SolverSettings&,
                     const haptics::SolverSettings&);

} // namespace midair::base

namespace midair::haptics
{

namespace
{

using S = SolverSettings;
using base::Row;

} // namespace

const base::SettingTable<SolverSettings>& solverSettings()
{
    static const base::SettingTable<S> table(
        {Row<S>("maxIterations",
                &S::maxIterations,
                "limit of the solver's iterations; 0: the solver's default")
             .range(0, 1000000)
             .noIdentity(),
         Row<S>("rmsTolerance", &S::rmsTolerance, "relative rms error at which the solver stops")
             .range(0.0, 1.0),
         Row<S>("deadline",
                &S::deadline_ms,
                "time limit of a solve, which then ends with its best field so far; 0: none")
             .range(0.0, 1e6, "ms")
             .noIdentity(),
         Row<S>("lambda", &S::lambda, "Tikhonov regularisation, relative to trace(K)/n")
             .range(0.0, base::kNoEnd),
         Row<S>("loudness",
                &S::loudness,
                "loudness; 1: the loudest accurate field; below: quieter; above: louder, less "
                "accurate")
             .range(1e-6, base::kMostLoudness)
             .safety(),
         Row<S>("phaseOnly", &S::phaseOnly, "play all transducers at one amplitude"),
         Row<S>("threads", &S::threads, "threads of the solver; at most one per core is used")
             .range(1, base::kMostThreads)
             .noIdentity()});
    return table;
}

} // namespace midair::haptics
