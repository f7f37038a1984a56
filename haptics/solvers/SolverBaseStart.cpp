// Third part of SolverBase: which points are solved for, and what of the last field is a start.
#include "haptics/solvers/SolverBase.h"

#include <algorithm>
#include <limits>
#include <unordered_map>

namespace midair::haptics
{

namespace
{

constexpr double kReach = 1e-3; // SOLVER.md, "Points out of reach": least row sum, over the largest
/// Least share of points that were in the last field too for its phases to be gone on from.
constexpr double kLeastKnown = 0.5;

} // namespace

void SolverBase::chooseActive(const ControlPoints& points)
{
    _points.active.clear();
    _points.identity.clear();
    const bool isIdentified = static_cast<int>(points.identity.size()) == points.size();
    for (int l = 0; l < points.size(); ++l)
    {
        if (!(points.targets[l] > 0.0)) continue;
        _points.active.push_back(l);
        if (isIdentified) _points.identity.push_back(points.identity[static_cast<std::size_t>(l)]);
    }
}

// Leaves out points that no transducer reaches. Returns true if there were any: the field then has
// to be assigned and built again.
bool SolverBase::dropUnreachable()
{
    double best = 0.0;
    for (int l = 0; l < _field.n(); ++l)
        best = std::max(best, _field.rowSum(l));
    const auto isReached = [&](std::size_t l)
    {
        const double sum = _field.rowSum(static_cast<int>(l));
        return sum > kReach * best && sum > std::numeric_limits<float>::min();
    };
    std::size_t kept = 0;
    for (std::size_t l = 0; l < _points.active.size(); ++l)
    {
        if (!isReached(l)) continue;
        _points.active[kept] = _points.active[l];
        if (!_points.identity.empty()) _points.identity[kept] = _points.identity[l];
        ++kept;
    }
    const bool dropped = kept != _points.active.size();
    _points.active.resize(kept);
    if (!_points.identity.empty()) _points.identity.resize(kept);
    return dropped;
}

// Returns true if the points are those of the last field, in its order.
bool SolverBase::areLastPoints() const
{
    if (_points.identity.empty() || _last.identity.empty()) return _points.active == _last.active;
    return _points.identity == _last.identity;
}

bool SolverBase::isContinued(const TransducerArray& array) const
{
    return _options.warmStart && _last.good && _last.q.size() == array.size() && areLastPoints();
}

// Finds each point in the last field. Returns true if enough of them were there.
bool SolverBase::findLastPoints()
{
    if (_points.identity.empty() || _last.identity.empty()) return false;
    std::unordered_map<std::uint64_t, int> last;
    last.reserve(_last.identity.size());
    for (std::size_t l = 0; l < _last.identity.size(); ++l)
        last.emplace(_last.identity[l], static_cast<int>(l));
    _points.lastOf.clear();
    int known = 0;
    for (const std::uint64_t identity : _points.identity)
    {
        const auto found = last.find(identity);
        _points.lastOf.push_back(found == last.end() ? -1 : found->second);
        known += found != last.end();
    }
    return known >= kLeastKnown * static_cast<double>(_points.identity.size());
}

// Goes on from the phases of the points that were in the last field; new ones take the phases that
// a field of the others has there. Returns false if the method can't.
bool SolverBase::goOn()
{
    if (!findLastPoints() || !carryOver(_field, _points.lastOf)) return false;
    for (std::size_t l = 0; l < _points.lastOf.size(); ++l)
    {
        const int last = _points.lastOf[l];
        const std::complex<float> u = last < 0 ? 1.0f : _last.u.at(static_cast<std::size_t>(last));
        _field.u.set(l, u);
        _field.w.set(l, last < 0 ? 0.0f : u * _field.a[static_cast<Eigen::Index>(l)]);
    }
    _field.projectRound(_field.w, _field.p);
    for (std::size_t l = 0; l < _points.lastOf.size(); ++l)
    {
        const float pressure = std::abs(_field.p.at(l));
        if (_points.lastOf[l] < 0 && pressure > kLeastPressure)
            _field.u.set(l, _field.p.at(l) / pressure);
    }
    return true;
}

// Sets the starting phases: those of the last field, which are computed at the points if these have
// changed; without a last field all are 1. Returns true if the points correspond to the last
// field's.
bool SolverBase::prepareStart(const TransducerArray& array)
{
    const bool warm = _options.warmStart && _last.good && _last.q.size() == array.size();
    if (!warm)
    {
        for (int l = 0; l < _field.n(); ++l)
            _field.u.set(static_cast<std::size_t>(l), 1.0f);
        return false;
    }
    if (isContinued(array) || goOn()) return true;
    _field.toLanes(_last.q, _field.q);
    _field.forward(_field.q, _field.p);
    _field.phasesOf(_field.p);
    return false;
}

} // namespace midair::haptics
