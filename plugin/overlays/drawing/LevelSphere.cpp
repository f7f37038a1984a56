#include "plugin/overlays/drawing/LevelSphere.h"

#include "haptics/base/Units.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace osgMidair
{

namespace
{

constexpr float kOutward = 1.002F; // lines lie in front of the faces, seen from inside

/// \a polar and \a turn: 0 .. 1, of half a turn and of a turn.
Eigen::Vector3d onSphere(double radius_m, double polar, double turn)
{
    const double a = midair::base::kPi * polar, b = midair::base::kTwoPi * turn;
    return radius_m *
           Eigen::Vector3d(std::sin(a) * std::cos(b), std::cos(a), std::sin(a) * std::sin(b));
}

/// The crossings of \a level_dB with the sides of a triangle: none, or two.
std::vector<osg::Vec3> crossings(const std::array<osg::Vec3, 3>& places,
                                 const std::array<float, 3>& levels_dB,
                                 float level_dB)
{
    std::vector<osg::Vec3> found;
    for (std::size_t a = 0; a < 3; ++a)
    {
        const std::size_t b = (a + 1) % 3;
        if ((levels_dB[a] < level_dB) == (levels_dB[b] < level_dB)) continue;
        const float share = (level_dB - levels_dB[a]) / (levels_dB[b] - levels_dB[a]);
        found.push_back((places[a] * (1.0F - share) + places[b] * share) / kOutward);
    }
    return found;
}

/// For each of four directions around the y axis, above the middle and below it, chooses the
/// nearest place, if one is near. \a turned: directions between those of the previous line.
void label(LevelSphere::Contour& contour, bool turned)
{
    constexpr float kNear = 0.92F; // cosine, of 23 degrees
    for (const float up : {1.0F, -1.0F})
        for (int quarter = 0; quarter < 4; ++quarter)
        {
            const float turn = static_cast<float>(midair::base::kTwoPi) *
                               (static_cast<float>(quarter) + (turned ? 0.5F : 0.0F)) / 4.0F;
            float nearest = kNear;
            const osg::Vec3* found = nullptr;
            for (const auto& piece : contour.pieces)
            {
                const osg::Vec3& place = piece.first;
                const float aside = std::hypot(place.x(), place.z());
                if (place.y() * up <= 0.0F || aside <= 0.0F) continue;
                const float cosine =
                    (place.x() * std::cos(turn) + place.z() * std::sin(turn)) / aside;
                if (cosine <= nearest) continue;
                nearest = cosine;
                found = &place;
            }
            if (found) contour.labels.push_back(*found);
        }
}

} // namespace

Eigen::Matrix3Xd LevelSphere::corners(double radius_m)
{
    Eigen::Matrix3Xd places(3, kRings * (kAround + 1));
    for (int ring = 0; ring < kRings; ++ring)
        for (int k = 0; k <= kAround; ++k)
            places.col(ring * (kAround + 1) + k) =
                onSphere(radius_m, double(ring) / (kRings - 1), double(k) / kAround);
    return places;
}

LevelSphere::Grid LevelSphere::gridOf(const Eigen::VectorXf& levels_dB, double radius_m)
{
    Grid grid;
    for (int row = 0; row < Grid::rows(); ++row)
        for (int column = 0; column < Grid::columns(); ++column)
        {
            const int ring = std::min(row / kFiner, kRings - 2);
            const int k = std::min(column / kFiner, kAround - 1);
            const float down = float(row - ring * kFiner) / kFiner;
            const float along = float(column - k * kFiner) / kFiner;
            const int at = ring * (kAround + 1) + k;
            const std::array<float, 4> around = {levels_dB[at],
                                                 levels_dB[at + 1],
                                                 levels_dB[at + kAround + 1],
                                                 levels_dB[at + kAround + 2]};
            const bool isHeard =
                std::all_of(around.begin(), around.end(), [](float level) { return level > 0.0F; });
            grid.levels_dB.push_back(
                isHeard ? (1.0F - down) * ((1.0F - along) * around[0] + along * around[1]) +
                              down * ((1.0F - along) * around[2] + along * around[3])
                        : 0.0F);
            const Eigen::Vector3d place = onSphere(
                radius_m, double(row) / (Grid::rows() - 1), double(column) / (Grid::columns() - 1));
            const Eigen::Vector3f p = place.cast<float>();
            grid.places.emplace_back(p.x(), p.y(), p.z());
        }
    const auto columns = static_cast<unsigned int>(Grid::columns());
    for (unsigned int row = 0; row + 1 < static_cast<unsigned int>(Grid::rows()); ++row)
        for (unsigned int column = 0; column + 1 < columns; ++column)
        {
            const unsigned int a = row * columns + column, b = a + columns;
            const std::array<unsigned int, 6> two = {a, b, a + 1, a + 1, b, b + 1};
            if (std::all_of(two.begin(),
                            two.end(),
                            [&](unsigned int corner) { return grid.levels_dB[corner] > 0.0F; }))
                grid.faces.insert(grid.faces.end(), two.begin(), two.end());
        }
    return grid;
}

std::vector<LevelSphere::Contour> LevelSphere::contoursOf(const Grid& grid, float step_dB)
{
    std::vector<Contour> contours;
    const float most_dB = *std::max_element(grid.levels_dB.begin(), grid.levels_dB.end());
    for (float level_dB = step_dB; level_dB <= most_dB; level_dB += step_dB)
    {
        Contour contour;
        contour.level_dB = level_dB;
        for (std::size_t face = 0; face + 2 < grid.faces.size(); face += 3)
        {
            std::array<osg::Vec3, 3> places;
            std::array<float, 3> levels_dB{};
            for (std::size_t corner = 0; corner < 3; ++corner)
            {
                places[corner] = grid.places[grid.faces[face + corner]];
                levels_dB[corner] = grid.levels_dB[grid.faces[face + corner]];
            }
            const std::vector<osg::Vec3> ends = crossings(places, levels_dB, level_dB);
            if (ends.size() != 2) continue;
            contour.pieces.emplace_back(ends[0], ends[1]);
        }
        label(contour, contours.size() % 2 == 1);
        if (!contour.pieces.empty()) contours.push_back(std::move(contour));
    }
    return contours;
}

} // namespace osgMidair
