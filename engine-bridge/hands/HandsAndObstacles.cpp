#include "engine-bridge/hands/HandsAndObstacles.h"

#include "engine-bridge/hands/HandProximity.h"
#include "engine-bridge/hands/Obstacles.h"

namespace midair::bridge
{

namespace
{

/// Written so that NaN counts as moved.
bool near(const Capsule& a, const Capsule& b)
{
    return (a.a - b.a).norm() <= kHandTolerance_m && (a.b - b.b).norm() <= kHandTolerance_m &&
           std::abs(a.radius_m - b.radius_m) <= kHandTolerance_m;
}

bool nearHands(const std::vector<HandCapsule>& a, const std::vector<HandCapsule>& b)
{
    if (a.size() != b.size()) return false;
    for (std::size_t i = 0; i < a.size(); ++i)
        if (a[i].hand != b[i].hand || a[i].bone != b[i].bone || !near(a[i].shape, b[i].shape))
            return false;
    return true;
}

bool nearProps(const std::vector<Capsule>& a, const std::vector<Capsule>& b)
{
    if (a.size() != b.size()) return false;
    for (std::size_t i = 0; i < a.size(); ++i)
        if (!near(a[i], b[i])) return false;
    return true;
}

} // namespace

bool equivalent(const HandsAndObstacles& a, const HandsAndObstacles& b)
{
    if (a.reach_m != b.reach_m || a.shadows != b.shadows) return false;
    if ((a.reach_m > 0.0 || a.shadows) && !nearHands(a.hands, b.hands)) return false;
    return !a.shadows || nearProps(a.props, b.props);
}

std::uint64_t ReachAndShadow::keepWithinReach(haptics::ControlPoints& points,
                                              Eigen::Matrix3Xd& skipped) const
{
    if (!(_last.reach_m > 0.0)) return 0;
    const std::vector<bool> within = withinReach(points.positions, _last.hands, _last.reach_m);
    std::vector<int> kept;
    const Eigen::Index before = skipped.cols();
    skipped.conservativeResize(3, before + points.size());
    Eigen::Index left = before;
    for (int l = 0; l < points.size(); ++l)
        if (within[static_cast<std::size_t>(l)])
            kept.push_back(l);
        else
            skipped.col(left++) = points.positions.col(l);
    skipped.conservativeResize(3, left);
    points = haptics::pick(points, kept);
    return static_cast<std::uint64_t>(left - before);
}

const haptics::TransducerArray& ReachAndShadow::shadowed(const haptics::ControlPoints& points,
                                                         const haptics::TransducerArray& array,
                                                         double wavelength_m)
{
    if (!_last.shadows || (_last.hands.empty() && _last.props.empty())) return array;
    std::vector<Capsule> obstacles = _last.props;
    for (const HandCapsule& hand : _last.hands)
        obstacles.push_back(hand.shape);
    ShadowOptions options;
    options.wavelength_m = wavelength_m;
    const Eigen::VectorXd gains = shadowGains(points.positions, array, obstacles, options);
    if ((gains.array() == 1.0).all()) return array;
    _shadowed = array;
    if (array.gain.size() == gains.size())
        _shadowed.gain = array.gain.cwiseProduct(gains);
    else
        _shadowed.gain = gains;
    return _shadowed;
}

} // namespace midair::bridge
