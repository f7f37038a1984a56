#pragma once

#include "haptics/array/BoardGrid.h"
#include "haptics/array/TransducerArray.h"

#include <Eigen/Core>

#include <array>
#include <string>
#include <vector>

namespace midair::haptics
{

/// A place that boards are measured to: a hook in the wall, or where a microphone was.
struct MeasuredPlace
{
    std::string name;
    Eigen::Vector3d position = Eigen::Vector3d::Zero(); ///< m, array frame
    bool isKnown = true;                                ///< false: known about; it is fitted along
};

/// One end of a measurement: a transducer, or a place.
struct MeasuredEnd
{
    std::string name;
    int transducer = -1; ///< -1: it is a place
    int place = -1;      ///< index; -1: it is a transducer
};

/// The distance of two ends: by a tape, or by the time that sound takes.
struct BoardMeasurement
{
    MeasuredEnd from, to;
    double distance_m = 0.0; ///< if not by time
    double time_s = 0.0;     ///< if by time
    bool isTime = false;     ///< with a delay that is common to all times, and fitted along
    int line = 0;            ///< of the file, from 1

    std::string name() const { return from.name + " - " + to.name; }
};

/// What was measured of an array's boards.
struct BoardMeasurements
{
    std::vector<MeasuredPlace> places;
    std::vector<BoardMeasurement> all;
};

/// Names of an array's transducers in measurements: "3:17" is transducer 17 of board 3, both from
/// 0, "3:a" to "3:d" are the four at the corners of board 3, "t847" is transducer 847 of all.
class BoardMarks
{
public:
    explicit BoardMarks(const TransducerArray& array);

    /// Returns the transducer's number; throws base::InputError, which says what would be right,
    /// for names of nothing.
    int find(const std::string& name) const;
    /// Returns the transducer at corner \a letter, 'a' to 'd', of \a board.
    int corner(int board, char letter) const;
    int boards() const { return static_cast<int>(_boards.size()); }
    int boardOf(int transducer) const { return _boardOf[static_cast<std::size_t>(transducer)]; }

private:
    std::vector<BoardRange> _boards;
    std::vector<int> _boardOf;
    std::vector<std::array<int, 4>> _corners;
};

/// Reads measurements, a line each, with blanks, commas, semicolons or tabs between the words:
///     place NAME x y z          a place that is known, metres or with a unit
///     place NAME about x y z    one that is known to some centimetres
///     END END DISTANCE          "0:a 1:b 151.2mm", metres without a unit
///     END END TIME              "t17 m1 683us": sound from the first to the second, or back
/// # begins a comment. \a source: the text's name in messages. Throws base::InputError, which names
/// the line.
BoardMeasurements readBoardMeasurements(const std::string& text,
                                        const std::string& source,
                                        const TransducerArray& array);

} // namespace midair::haptics
