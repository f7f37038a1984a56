#pragma once

#include <limits>
#include <map>

namespace midair::bridge
{

/// Who plays when several want to: what has the highest priority, and all that share it; the rest
/// fades out, and in again.
class Precedence
{
public:
    static constexpr double kFade_s = 0.02;

    /// Advances the fades by \a dt_s (>= 0). \a highest: the highest priority of all that play now.
    void advance(double dt_s, int highest);
    /// Returns the factor, 0 .. 1, on the pressure of what has this priority. A priority that is
    /// asked for the first time doesn't fade.
    double level(int priority);
    /// Returns true while something has faded that nothing makes give way any more, or will.
    bool isFading() const;

private:
    int _highest = std::numeric_limits<int>::min();
    std::map<int, double> _levels;
};

} // namespace midair::bridge
