#include "haptics/solvers/many/ManyFields.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Range.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/ThreadPool.h"
#include "haptics/solvers/many/FieldPath.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <limits>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

constexpr double kMostTarget = 1e12; // as SolverBase
constexpr double kLeastSteps = 4.0;  // of the bound on phase changes, in steps of the phases

/// The first of several paths' errors, in the order of the paths.
class FirstError
{
public:
    void keep(int path, std::exception_ptr error)
    {
        const base::Lock lock(_mutex);
        if (_error && _path <= path) return;
        _path = path;
        _error = std::move(error);
    }
    void rethrow()
    {
        const base::Lock lock(_mutex);
        if (_error) std::rethrow_exception(_error);
    }

private:
    base::Mutex _mutex;
    int _path MIDAIR_GUARDED_BY(_mutex) = 0;
    std::exception_ptr _error MIDAIR_GUARDED_BY(_mutex);
};

void checkTargets(const double* targets, int points, int field)
{
    double largest = 0.0;
    for (int l = 0; l < points; ++l)
    {
        if (!(targets[l] >= 0.0) || targets[l] > kMostTarget)
            throw base::InputError(
                fmt::format("point {} of field {} has the target {:g}; targets are 0 .. {:g}",
                            l,
                            field,
                            targets[l],
                            kMostTarget));
        largest = std::max(largest, targets[l]);
    }
    if (!(largest >= std::numeric_limits<double>::min()))
        throw base::InputError(fmt::format(
            "field {} has only targets of 0: phases of full amplitude can't be silent", field));
}

} // namespace

bool ManyFieldsOptions::isValid(std::string* error) const
{
    return base::RangeCheck("option of many fields ")
        .within("threads", threads, 1, base::kMostThreads)
        .within("rmsTolerance", rmsTolerance, 3e-4, 0.3)
        .atLeast("fieldsInPath", fieldsInPath, 0)
        .within("largestPhaseStep_rad", largestPhaseStep_rad, 0.0, base::kPi)
        .passed(error);
}

ManyFields::ManyFields(const TransducerArray& array,
                       const Medium& medium,
                       const ManyFieldsOptions& options) :
    _options(options),
    _transducers(array.size())
{
    std::string why;
    if (!array.isValid(&why)) throw base::InputError("the array of many fields: " + why);
    if (!medium.isValid(&why)) throw base::InputError("the air of many fields: " + why);
    if (!options.isValid(&why)) throw base::InputError(why);
    const int levels = phaseLevelsOf(array);
    if (levels > kMostPhaseLevels)
        throw base::InputError(fmt::format(
            "the array plays {} phases; many fields have at most {}", levels, kMostPhaseLevels));
    const double least = std::min(kLeastSteps * phaseStepOf_rad(array), base::kPi);
    if (options.largestPhaseStep_rad > 0.0 && options.largestPhaseStep_rad < (1.0 - 1e-6) * least)
        throw base::InputError(
            fmt::format("option of many fields largestPhaseStep_rad is {:g}; for "
                        "{} phases it must be 0 (no bound) or {:g} .. {:g}",
                        options.largestPhaseStep_rad,
                        levels,
                        least,
                        base::kPi));
    _pool = std::make_unique<base::ThreadPool>(options.threads);
    for (int thread = 0; thread < options.threads; ++thread)
        _paths.push_back(std::make_unique<FieldPath>(array, medium, options));
}

ManyFields::~ManyFields() = default;

void ManyFields::check(const ManyPoints& points) const
{
    const int n = points.points;
    std::string why;
    if (!base::RangeCheck("number of ")
             .within("fields", points.fields, 1, 1e9)
             .within("points", n, 1, kMostPoints)
             .passed(&why))
        throw base::InputError(why);
    if (static_cast<std::size_t>(n) * static_cast<std::size_t>(_transducers) > base::kMostEntries)
        throw base::InputError(fmt::format("{} points times {} transducers are more than {}",
                                           n,
                                           _transducers,
                                           base::kMostEntries));
    if (points.positions == nullptr) throw base::InputError("many fields need positions");
    for (int field = 0; field < points.fields; ++field)
        for (int l = 0; l < n; ++l)
        {
            const double* r = points.positions + 3 * (static_cast<std::ptrdiff_t>(field) * n + l);
            if (std::isfinite(r[0]) && std::isfinite(r[1]) && std::isfinite(r[2])) continue;
            throw base::InputError(
                fmt::format("point {} of field {} is at ({:g}, {:g}, {:g}); coordinates must be "
                            "finite",
                            l,
                            field,
                            r[0],
                            r[1],
                            r[2]));
        }
    if (points.targets == nullptr) return;
    for (int field = 0; field < (points.sameTargets ? 1 : points.fields); ++field)
        checkTargets(points.targets + static_cast<std::ptrdiff_t>(field) * n, n, field);
}

void ManyFields::solve(const ManyPoints& points, std::uint8_t* phases, ManyFieldsFigures* figures)
{
    check(points);
    if (phases == nullptr) throw base::InputError("many fields need room for phases");
    const int length = _options.fieldsInPath > 0 ? _options.fieldsInPath : points.fields;
    const int paths = points.fields / length + (points.fields % length > 0 ? 1 : 0);
    std::atomic<int> next{0};
    FirstError error;
    _pool->run(
        [&](int thread)
        {
            FieldPath& solver = *_paths[static_cast<std::size_t>(thread)];
            for (int path = next++; path < paths; path = next++)
                try
                {
                    const int first = path * length;
                    const int end = first + std::min(length, points.fields - first);
                    solver.begin(path);
                    for (int field = first; field < end; ++field)
                    {
                        _options.stop.throwIfRequested();
                        const auto k = static_cast<std::size_t>(field);
                        solver.solve(points,
                                     field,
                                     phases + k * static_cast<std::size_t>(_transducers),
                                     figures != nullptr ? figures + k : nullptr);
                    }
                }
                catch (...)
                {
                    error.keep(path, std::current_exception());
                    next = paths;
                }
        });
    error.rethrow();
}

} // namespace midair::haptics
