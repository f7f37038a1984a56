#pragma once

#include "device/ArrayDevice.h"

#include <array>
#include <string>
#include <vector>

namespace midair::device
{

/// The caps that the user's environment sets for everything that a program plays, be it a scene of
/// the kit or of the C interface, a pattern, a plan or a recording. Each variable counts as it was
/// when the program began and as it is now, the stricter of both, so that a later one can only
/// restrict.
struct UserCaps
{
    double maxAmplitude = 1;   ///< 0 .. 1 of full drive; OSG_MIDAIR_MAX_AMPLITUDE
    double maxPressure_Pa = 0; ///< peak, 0 .. 1e6; 0: none; OSG_MIDAIR_MAX_PRESSURE
    /// dB re 20 uPa, rms, 20 .. 200; 0: none; OSG_MIDAIR_EAR_LIMIT, where "none" is 0 as well
    double earLimit_dB = 0;
    /// Listening places besides those around the array and those that a scene names, as
    /// base::parsePlaces() reads them; OSG_MIDAIR_EAR_POINTS
    std::string earPoints;
    /// The user chose an ear limit, or none by word.
    bool isEarLimitChosen = false;
    /// Something that isn't understood, and is told by itself, keeps everything silent.
    bool isSilencing = false;
    /// What is wrong with variables, a sentence each that names the variable, its value and what
    /// would be right. Unless it is empty nothing may be played.
    std::vector<std::string> wrong;
};

bool operator==(const UserCaps& a, const UserCaps& b);

/// The environment as it is now: whoever plays asks whenever it matters, not once. This is the one
/// reader of these variables. They are in userCapVariables(). Any thread.
UserCaps capsOfUser();

/// The names of the variables that capsOfUser() reads.
const std::vector<std::string>& userCapVariables();

/// Returns \a a with what \a b restricts beyond it: places of both are listened at.
UserCaps stricter(UserCaps a, const UserCaps& b);

/// Returns both texts of places as one.
std::string joinedPlaces(const std::string& a, const std::string& b);

} // namespace midair::device
