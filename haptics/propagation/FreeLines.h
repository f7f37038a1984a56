#pragma once

#include "haptics/array/TransducerArray.h"

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// Tells which transducers a place hears directly: those with D > 0 towards it whose straight line
/// to it passes beside all boards. A board is the rectangle around the transducers of one number in
/// TransducerArray::board, if there are at least four in one plane; it hides what is behind it, of
/// its own transducers, too. What isn't such a board hides nothing.
class FreeLines
{
public:
    explicit FreeLines(const TransducerArray& array);

    /// Returns true if nothing is between transducer \a i of the array and \a place (metres, array
    /// frame).
    bool isFree(Eigen::Index i, const Eigen::Vector3d& place) const;

private:
    struct Rectangle
    {
        Eigen::Vector3d corner; ///< of its transducers, one
        Eigen::Vector3d normal; ///< unit length, as the transducers'
        Eigen::Vector3d u;      ///< unit length, in the plane
        Eigen::Vector3d v;
        Eigen::Vector2d low; ///< metres along u and v from the corner
        Eigen::Vector2d high;
    };

    void addBoard(const TransducerArray& array, Eigen::Index first, Eigen::Index last);

    Eigen::Matrix3Xd _positions;
    std::vector<Rectangle> _boards;
    std::vector<int> _own; ///< m: number of its rectangle; -1: none
};

} // namespace midair::haptics
