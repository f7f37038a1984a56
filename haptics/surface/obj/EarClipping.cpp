#include "haptics/surface/obj/EarClipping.h"

#include <Eigen/Geometry>

#include <cmath>
#include <limits>

namespace midair::haptics
{

namespace
{

/// Cuts off a polygon's ears: convex corners whose triangle has no other corner inside (G. H.
/// Meisters, "Polygons have ears", 1975). What is no ear is looked at again only if its neighbours
/// change, so that a polygon that doesn't cross itself takes O(n^2).
class EarClipping
{
public:
    explicit EarClipping(const Eigen::Matrix3Xd& corners);
    void run();

    std::vector<std::array<int, 3>> triangles;
    bool isClean = true; ///< no triangle is turned over

private:
    int& before(int corner) { return _before[static_cast<std::size_t>(corner)]; }
    int& after(int corner) { return _after[static_cast<std::size_t>(corner)]; }
    double turn(int a, int b, int c) const;
    bool isEar(int corner);
    int cut(int corner);
    int flattest(int from);

    Eigen::Matrix2Xd _places;
    std::vector<int> _before; ///< in the ring of what is left
    std::vector<int> _after;
    std::vector<bool> _isKnown; ///< to be no ear, as long as its neighbours stay
    int _left;
    double _flat; ///< twice the area below which three corners are in line
};

// The normal by Newell's method; the axis along which it is longest is left out.
EarClipping::EarClipping(const Eigen::Matrix3Xd& corners) :
    _places(2, corners.cols()),
    _isKnown(static_cast<std::size_t>(corners.cols()), false),
    _left(static_cast<int>(corners.cols()))
{
    const Eigen::Matrix3Xd at = corners.colwise() - corners.col(0).eval();
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    for (int i = 0; i < _left; ++i)
    {
        const int next = (i + 1) % _left;
        normal += Eigen::Vector3d(at.col(i)).cross(Eigen::Vector3d(at.col(next)));
        _before.push_back((i + _left - 1) % _left);
        _after.push_back(next);
    }
    Eigen::Index away = 0;
    normal.cwiseAbs().maxCoeff(&away);
    const bool isTurned = normal[away] < 0.0;
    _places.row(isTurned ? 1 : 0) = at.row((away + 1) % 3);
    _places.row(isTurned ? 0 : 1) = at.row((away + 2) % 3);
    _flat = 1e-14 * at.colwise().squaredNorm().maxCoeff();
}

void EarClipping::run()
{
    constexpr int kMostStuck =
        16; // then it crosses itself all over, and what is cut off matters no more
    int stuck = 0;
    int misses = 0;
    bool isFresh = false; // all that is left was looked at again
    // Quads are split along their shorter diagonal, if it is inside.
    const auto diagonal2 = [this](int from)
    { return (_places.col(from) - _places.col(from + 2)).squaredNorm(); };
    int corner = _left == 4 && diagonal2(0) < diagonal2(1) ? 1 : 0;
    while (_left > 3)
    {
        if (stuck > kMostStuck || (!_isKnown[static_cast<std::size_t>(corner)] && isEar(corner)))
        {
            corner = cut(corner);
            misses = 0;
            isFresh = false;
            continue;
        }
        _isKnown[static_cast<std::size_t>(corner)] = true;
        corner = after(corner);
        if (++misses < _left) continue;
        misses = 0;
        if (isFresh)
        {
            corner = cut(flattest(corner));
            ++stuck;
        }
        else
            _isKnown.assign(_isKnown.size(), false);
        isFresh = !isFresh;
    }
    cut(corner);
}

/// Twice the area of three corners; over 0: they turn as the polygon does.
double EarClipping::turn(int a, int b, int c) const
{
    const Eigen::Vector2d ab = _places.col(b) - _places.col(a);
    const Eigen::Vector2d ac = _places.col(c) - _places.col(a);
    return ab.x() * ac.y() - ab.y() * ac.x();
}

bool EarClipping::isEar(int corner)
{
    const int a = before(corner);
    const int c = after(corner);
    if (!(turn(a, corner, c) > _flat)) return false;
    for (int i = after(c); i != a; i = after(i))
    {
        // Where a hole is joined to the outline, two corners are in one place.
        const auto isAt = [&](int other) { return _places.col(i) == _places.col(other); };
        if (isAt(a) || isAt(corner) || isAt(c)) continue;
        if (turn(a, corner, i) >= 0.0 && turn(corner, c, i) >= 0.0 && turn(c, a, i) >= 0.0)
            return false;
    }
    return true;
}

/// Returns the next corner.
int EarClipping::cut(int corner)
{
    const int a = before(corner);
    const int c = after(corner);
    if (turn(a, corner, c) < -_flat) isClean = false;
    // From the lowest one on.
    if (corner < a && corner < c)
        triangles.push_back({corner, c, a});
    else if (c < a)
        triangles.push_back({c, a, corner});
    else
        triangles.push_back({a, corner, c});
    --_left;
    after(a) = c;
    before(c) = a;
    _isKnown[static_cast<std::size_t>(a)] = _isKnown[static_cast<std::size_t>(c)] = false;
    return c;
}

/// The corner whose cutting off does the least harm, where none is an ear.
int EarClipping::flattest(int from)
{
    int best = from;
    double least = std::numeric_limits<double>::infinity();
    for (int i = from, n = 0; n < _left; ++n, i = after(i))
    {
        const double size = std::abs(turn(before(i), i, after(i)));
        if (!(size < least)) continue;
        best = i;
        least = size;
    }
    return best;
}

} // namespace

std::vector<std::array<int, 3>> triangulated(const Eigen::Matrix3Xd& corners, bool& crosses)
{
    EarClipping ears(corners);
    ears.run();
    crosses = !ears.isClean;
    return std::move(ears.triangles);
}

} // namespace midair::haptics
