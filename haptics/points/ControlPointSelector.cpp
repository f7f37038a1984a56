#include "haptics/points/ControlPointSelector.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/Range.h"
#include "haptics/surface/PointGrid.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <string>
#include <tuple>
#include <vector>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

/// Farthest-point selection that starts with the first sample: it spreads the chosen points evenly,
/// and they stay the same while the object moves.
void spread(const std::vector<BudgetPoint>& points,
            const std::vector<std::size_t>& members,
            int quota,
            const base::StopToken& stop,
            std::vector<char>& keep)
{
    std::vector<std::size_t> order = members;
    std::sort(order.begin(),
              order.end(),
              [&](std::size_t a, std::size_t b) { return points[a].sample < points[b].sample; });
    std::vector<double> distance2(order.size(), std::numeric_limits<double>::infinity());
    std::size_t next = 0;
    for (int taken = 0; taken < quota; ++taken)
    {
        stop.throwIfRequested();
        keep[order[next]] = 1;
        const Eigen::Vector3d point = points[order[next]].position;
        distance2[next] = -1.0;
        std::size_t farthest = next;
        for (std::size_t i = 0; i < order.size(); ++i)
        {
            if (distance2[i] < 0.0) continue;
            distance2[i] =
                std::min(distance2[i], (points[order[i]].position - point).squaredNorm());
            if (distance2[i] > distance2[farthest]) farthest = i;
        }
        next = farthest;
    }
}

/// Tolerance for the rounding of poses: points sampled exactly a spacing apart are not too near.
constexpr double kSlack = 1.0 - 1e-6;

/// Point that is still in the selection.
struct Candidate
{
    int source;
    int sample;
    Eigen::Vector3d position;
    Eigen::Vector3d normal;
    double target;
    Eigen::Vector3d positionSum; ///< sum over all points merged into it
    Eigen::Vector3d normalSum;
    int merged = 1;
};

/// Passes the candidates through the stages of a selection; each stage leaves some out.
class Selector
{
public:
    Selector(const std::vector<PosedObject>& objects,
             const Workspace& workspace,
             const SelectorOptions& options) :
        _objects(objects),
        _workspace(workspace),
        _options(options),
        _look(options.stop, 16)
    {
        _report.perObject.assign(objects.size(), 0);
        _report.leftOut.resize(objects.size());
        for (const PosedObject& object : objects)
        {
            _largestSpacing = std::max(_largestSpacing, object.spacing_m);
        }
        _crowd = options.crowdingWavelengths * workspace.wavelength_m();
    }

    Selection run()
    {
        collect();
        sort();
        if (_options.crowding == Crowding::DROP) dropCrowds();
        thin(_options.crowding == Crowding::MERGE);
        if (_options.crowding == Crowding::MERGE)
        {
            moveMerged();
            thin(false); // merged points may be too near to others
        }
        keepBudget();
        return finish();
    }

private:
    const PosedObject& objectOf(const Candidate& candidate) const
    {
        return _objects[static_cast<std::size_t>(candidate.source)];
    }
    /// Returns the distance, m, below which two points are a crowd.
    double crowdLimit(const Candidate& a, const Candidate& b) const
    {
        return a.source == b.source ? std::min(_crowd, objectOf(a).spacing_m) : _crowd;
    }
    LeftOutPoints& leftOutOf(const Candidate& candidate)
    {
        return _report.leftOut[static_cast<std::size_t>(candidate.source)];
    }
    double searchRadius() const { return std::max({_largestSpacing, _crowd, kLeastCell}); }
    PointGrid grid() const
    {
        PointGrid points(searchRadius());
        points.reserve(_candidates.size());
        return points;
    }

    void collect()
    {
        for (std::size_t source = 0; source < _objects.size(); ++source)
        {
            const PosedObject& object = _objects[source];
            const Eigen::Index count = object.positions.cols();
            _report.candidates += static_cast<int>(count);
            for (Eigen::Index i = 0; i < count; ++i)
            {
                _look.turn();
                const double intensity =
                    object.intensity.size() > 0 ? static_cast<double>(object.intensity[i]) : 1.0;
                const Candidate candidate{static_cast<int>(source),
                                          static_cast<int>(i),
                                          object.positions.col(i),
                                          object.normals.col(i),
                                          object.target * intensity,
                                          object.positions.col(i),
                                          object.normals.col(i)};
                if (accept(candidate)) _candidates.push_back(candidate);
            }
        }
    }
    bool accept(const Candidate& candidate)
    {
        const double length = candidate.normal.norm();
        if (!candidate.position.allFinite() || !std::isfinite(length) ||
            !std::isfinite(candidate.target))
        {
            ++_report.notFinite;
            ++leftOutOf(candidate).notFinite;
            return false;
        }
        if (!(candidate.target > 0.0))
        {
            ++_report.noTarget;
            ++leftOutOf(candidate).noTarget;
            return false;
        }
        switch (_workspace.judge(candidate.position))
        {
        case Workspace::Verdict::INSIDE:
            return true;
        case Workspace::Verdict::TOO_CLOSE:
            ++_report.tooClose;
            ++leftOutOf(candidate).tooClose;
            break;
        case Workspace::Verdict::BEHIND:
            ++_report.behind;
            ++leftOutOf(candidate).behind;
            break;
        case Workspace::Verdict::AT_REFLECTOR:
            ++_report.atReflector;
            ++leftOutOf(candidate).atReflector;
            break;
        case Workspace::Verdict::OUT_OF_REACH:
            ++_report.outOfReach;
            break;
        }
        ++leftOutOf(candidate).outOfWorkspace;
        return false;
    }
    void sort()
    {
        const auto key = [this](const Candidate& c)
        {
            return std::make_tuple(-static_cast<long>(objectOf(c).priority),
                                   c.position.squaredNorm(),
                                   c.position.x(),
                                   c.position.y(),
                                   c.position.z(),
                                   objectOf(c).object);
        };
        std::stable_sort(_candidates.begin(),
                         _candidates.end(),
                         [&](const Candidate& a, const Candidate& b) { return key(a) < key(b); });
    }
    void dropCrowds()
    {
        PointGrid points = grid();
        std::vector<char> crowded(_candidates.size(), 0);
        for (std::size_t i = 0; i < _candidates.size(); ++i)
        {
            _look.turn();
            points.visitNear(_candidates[i].position,
                             searchRadius(),
                             [&](int near, double d2)
                             {
                                 const auto other = static_cast<std::size_t>(near);
                                 const double limit =
                                     kSlack * crowdLimit(_candidates[i], _candidates[other]);
                                 if (d2 < limit * limit) crowded[i] = crowded[other] = 1;
                                 return false;
                             });
            points.insert(_candidates[i].position);
        }
        std::vector<Candidate> kept;
        for (std::size_t i = 0; i < _candidates.size(); ++i)
        {
            if (crowded[i] == 0)
                kept.push_back(_candidates[i]);
            else
                ++leftOutOf(_candidates[i]).crowded;
        }
        _report.crowdDropped += static_cast<int>(_candidates.size() - kept.size());
        _candidates = std::move(kept);
    }
    /// Keeps the first of points that are too close together, in their order.
    void thin(bool merge)
    {
        PointGrid points = grid();
        std::vector<Candidate> kept;
        for (const Candidate& candidate : _candidates)
        {
            _look.turn();
            int crowdedBy = -1;
            double nearest2 = std::numeric_limits<double>::infinity();
            bool spaced = true;
            points.visitNear(candidate.position,
                             searchRadius(),
                             [&](int near, double d2)
                             {
                                 const Candidate& other = kept[static_cast<std::size_t>(near)];
                                 const double limit = kSlack * crowdLimit(candidate, other);
                                 const double spacing =
                                     candidate.source == other.source
                                         ? 0.0
                                         : kSlack * std::max(objectOf(candidate).spacing_m,
                                                             objectOf(other).spacing_m);
                                 if (d2 < limit * limit &&
                                     (d2 < nearest2 || (d2 == nearest2 && near < crowdedBy)))
                                 {
                                     crowdedBy = near;
                                     nearest2 = d2;
                                 }
                                 spaced = spaced && d2 >= spacing * spacing;
                                 return false;
                             });
            if (crowdedBy >= 0 || !spaced) ++leftOutOf(candidate).crowded;
            if (crowdedBy >= 0 && merge)
            {
                Candidate& into = kept[static_cast<std::size_t>(crowdedBy)];
                into.positionSum += candidate.position;
                into.normalSum += candidate.normal;
                into.target = std::max(into.target, candidate.target);
                ++into.merged;
                ++_report.crowdMerged;
            }
            else if (crowdedBy >= 0)
            {
                ++_report.crowdThinned;
            }
            else if (!spaced)
            {
                ++_report.spacedOut;
            }
            else
            {
                points.insert(candidate.position);
                kept.push_back(candidate);
            }
        }
        _candidates = std::move(kept);
    }
    void moveMerged()
    {
        for (Candidate& candidate : _candidates)
        {
            if (candidate.merged == 1) continue;
            candidate.position = candidate.positionSum / candidate.merged;
            if (candidate.normalSum.norm() > 1e-6)
                candidate.normal = candidate.normalSum.normalized();
        }
    }
    void keepBudget()
    {
        if (static_cast<int>(_candidates.size()) <= _options.maxPoints) return;
        std::vector<BudgetPoint> points;
        points.reserve(_candidates.size());
        for (const Candidate& candidate : _candidates)
        {
            const PosedObject& object = objectOf(candidate);
            points.push_back({object.priority,
                              object.object,
                              candidate.source,
                              candidate.sample,
                              candidate.position});
        }
        const std::vector<char> keep = shareBudget(points, _options.maxPoints, _options.stop);
        std::vector<Candidate> kept;
        for (std::size_t i = 0; i < _candidates.size(); ++i)
            if (keep[i] != 0)
                kept.push_back(_candidates[i]);
            else
                ++leftOutOf(_candidates[i]).overBudget;
        _report.overBudget = static_cast<int>(_candidates.size() - kept.size());
        _candidates = std::move(kept);
    }
    Selection finish()
    {
        std::sort(_candidates.begin(),
                  _candidates.end(),
                  [](const Candidate& a, const Candidate& b)
                  { return std::tie(a.source, a.sample) < std::tie(b.source, b.sample); });
        Selection selection;
        const auto n = static_cast<Eigen::Index>(_candidates.size());
        selection.points.positions.resize(3, n);
        selection.points.normals.resize(3, n);
        selection.points.targets.resize(n);
        const bool isIdentified =
            std::none_of(_objects.begin(),
                         _objects.end(),
                         [](const PosedObject& object) { return object.identity.empty(); });
        for (Eigen::Index i = 0; i < n; ++i)
        {
            const Candidate& candidate = _candidates[static_cast<std::size_t>(i)];
            selection.points.positions.col(i) = candidate.position;
            selection.points.normals.col(i) = candidate.normal;
            selection.points.targets[i] = candidate.target;
            const PosedObject& object = objectOf(candidate);
            selection.points.object.push_back(object.object);
            if (isIdentified)
                selection.points.identity.push_back(
                    object.identity[static_cast<std::size_t>(candidate.sample)]);
            selection.source.push_back(candidate.source);
            selection.sample.push_back(candidate.sample);
            ++_report.perObject[static_cast<std::size_t>(candidate.source)];
        }
        _report.selected = static_cast<int>(n);
        selection.report = _report;
        return selection;
    }

    static constexpr double kLeastCell = 1e-6; ///< m

    const std::vector<PosedObject>& _objects;
    const Workspace& _workspace;
    const SelectorOptions& _options;
    base::StopLook _look;
    double _largestSpacing = 0.0;
    double _crowd = 0.0;
    std::vector<Candidate> _candidates;
    SelectionReport _report;
};

void checkObject(const PosedObject& object, std::size_t index)
{
    const Eigen::Index n = object.positions.cols();
    if (object.normals.cols() != n ||
        (object.intensity.size() != 0 && object.intensity.size() != n) ||
        (!object.identity.empty() && static_cast<Eigen::Index>(object.identity.size()) != n))
        throw base::InputError(fmt::format("Object {} has {} positions, {} normals, {} intensities "
                                           "and {} identities; they must be as many",
                                           index,
                                           n,
                                           object.normals.cols(),
                                           object.intensity.size(),
                                           object.identity.size()));
    if (!(object.spacing_m > 0.0) || !std::isfinite(object.spacing_m))
        throw base::InputError(
            fmt::format("Object {} has the spacing {:g} m; it must be positive and finite",
                        index,
                        object.spacing_m));
}

/// Adds "COUNT WHAT" to \a lost, unless there are none.
auto teller(std::vector<std::string>& lost)
{
    return [&lost](int count, const char* what)
    {
        if (count != 0) lost.push_back(fmt::format("{} {}", count, what));
    };
}

} // namespace

void PosedObject::pose(const SurfaceSamples& samples,
                       const Eigen::Isometry3d& meshToArray,
                       std::uint64_t first)
{
    positions.noalias() = meshToArray.linear() * samples.positions;
    positions.colwise() += meshToArray.translation();
    normals.noalias() = meshToArray.linear() * samples.normals;
    intensity = samples.intensity;
    identity.resize(static_cast<std::size_t>(positions.cols()));
    std::iota(identity.begin(), identity.end(), first);
}

void PosedObject::keepIf(const std::function<bool(Eigen::Index)>& isKept)
{
    Eigen::Index kept = 0;
    for (Eigen::Index i = 0; i < positions.cols(); ++i)
    {
        if (!isKept(i)) continue;
        positions.col(kept) = positions.col(i);
        normals.col(kept) = normals.col(i);
        if (intensity.size() > 0) intensity[kept] = intensity[i];
        if (!identity.empty())
            identity[static_cast<std::size_t>(kept)] = identity[static_cast<std::size_t>(i)];
        ++kept;
    }
    positions.conservativeResize(3, kept);
    normals.conservativeResize(3, kept);
    if (intensity.size() > 0) intensity.conservativeResize(kept);
    if (!identity.empty()) identity.resize(static_cast<std::size_t>(kept));
}

std::vector<char>
shareBudget(const std::vector<BudgetPoint>& points, int maxPoints, const base::StopToken& stop)
{
    std::vector<char> keep(points.size(), 0);
    std::map<int, std::map<int, std::vector<std::size_t>>, std::greater<>> groups;
    for (std::size_t i = 0; i < points.size(); ++i)
    {
        groups[points[i].priority][points[i].source].push_back(i);
    }
    int left = maxPoints;
    for (const auto& [priority, members] : groups)
    {
        int total = 0;
        for (const auto& member : members)
            total += static_cast<int>(member.second.size());
        const int share = std::min(left, total);
        std::vector<std::tuple<double, int, int, int>> parts; // -remainder, object, source, quota
        int given = 0;
        for (const auto& [source, own] : members)
        {
            const double exact =
                static_cast<double>(share) * static_cast<double>(own.size()) / total;
            const int quota = static_cast<int>(exact);
            const int object = points[own.front()].object;
            parts.emplace_back(quota - exact, object, source, quota);
            given += quota;
        }
        std::sort(parts.begin(), parts.end());
        for (auto& part : parts)
        {
            const auto& own = members.at(std::get<2>(part));
            int& quota = std::get<3>(part);
            if (given < share && quota < static_cast<int>(own.size()))
            {
                ++quota;
                ++given;
            }
            spread(points, own, quota, stop, keep);
        }
        left -= share;
    }
    return keep;
}

bool SelectorOptions::isValid(std::string* error) const
{
    return base::RangeCheck("SelectorOptions::")
        .atLeast("maxPoints", maxPoints, 1)
        .within("crowdingWavelengths", crowdingWavelengths, 0.0, 1.0)
        .atLeast("minDistanceWavelengths", minDistanceWavelengths, 0.0)
        .atLeast("reach_m", reach_m, 0.0)
        .passed(error);
}

Selection selectControlPoints(const std::vector<PosedObject>& objects,
                              const Workspace& workspace,
                              const SelectorOptions& options)
{
    std::string error;
    if (!options.isValid(&error)) throw base::InputError(error);
    for (std::size_t i = 0; i < objects.size(); ++i)
        checkObject(objects[i], i);
    return Selector(objects, workspace, options).run();
}

LeftOutPoints& LeftOutPoints::operator+=(const LeftOutPoints& other)
{
    notFinite += other.notFinite;
    noTarget += other.noTarget;
    outOfWorkspace += other.outOfWorkspace;
    tooClose += other.tooClose;
    behind += other.behind;
    atReflector += other.atReflector;
    crowded += other.crowded;
    overBudget += other.overBudget;
    return *this;
}

std::string LeftOutPoints::summary() const
{
    std::vector<std::string> lost;
    const auto tell = teller(lost);
    tell(notFinite, "not finite");
    tell(noTarget, "without a positive target");
    tell(outOfWorkspace - behind - tooClose - atReflector, "out of reach");
    tell(behind, "behind the array");
    tell(tooClose, "too close to a transducer");
    tell(atReflector, "nearer than a wavelength to a reflector");
    tell(crowded, "too near another point");
    tell(overBudget, "over the budget");
    return fmt::format("{}", fmt::join(lost, ", "));
}

std::string SelectionReport::summary() const
{
    if (selected == candidates) return "";
    std::vector<std::string> lost;
    const auto tell = teller(lost);
    tell(notFinite, "not finite");
    tell(noTarget, "without a positive target");
    tell(outOfReach, "out of reach");
    tell(behind, "behind the array");
    tell(tooClose, "too close to a transducer");
    tell(atReflector, "nearer than a wavelength to a reflector");
    tell(crowdDropped, "dropped from crowds");
    tell(crowdMerged, "merged into others");
    tell(crowdThinned, "thinned from crowds");
    tell(spacedOut, "too near another object's");
    tell(overBudget, "over the budget");
    const char* why = lost.empty() ? "" : ": ";
    return fmt::format("{} of {} points{}{}", selected, candidates, why, fmt::join(lost, ", "));
}

} // namespace midair::haptics
