#pragma once

#include "device/ArrayDevice.h"

#include <array>
#include <string>
#include <vector>

namespace midair::device
{

/// Caps that the user's environment sets for all output of a program: scenes of the kit or of the C
/// interface, patterns, plans and recordings. The stricter of a variable's values at program start
/// and now applies, so later changes can only restrict.
struct UserCaps
{
    double maxAmplitude = 1;   ///< 0 .. 1 of full drive; OSG_MIDAIR_MAX_AMPLITUDE
    double maxPressure_Pa = 0; ///< peak, 0 .. 1e6; 0: none; OSG_MIDAIR_MAX_PRESSURE
    /// dB re 20 uPa, rms, 20 .. 200; 0: none; OSG_MIDAIR_EAR_LIMIT, where "none" also means 0
    double earLimit_dB = 0;
    /// Listening places in addition to those around the array and those of a scene, as for
    /// base::parsePlaces(); OSG_MIDAIR_EAR_POINTS
    std::string earPoints;
    /// The user chose an ear limit, or "none".
    bool isEarLimitChosen = false;
    /// Nothing may be played: OSG_MIDAIR_ENABLED is false, or a scene has a fault that is reported
    /// by itself.
    bool isSilencing = false;
    /// Errors in variables, a sentence each that names the variable, its value and the expected
    /// value. Nothing may be played unless it is empty.
    std::vector<std::string> wrong;
};

bool operator==(const UserCaps& a, const UserCaps& b);

/// Returns the caps of the present environment. Call it whenever they matter, not once. Only this
/// function reads these variables, which userCapVariables() lists. Any thread.
UserCaps capsOfUser();

/// Why nothing may be played while capsOfUser() silences.
constexpr const char* kDisabledByUser = "OSG_MIDAIR_ENABLED is false; nothing is played";

/// Returns the names of the variables read by capsOfUser().
const std::vector<std::string>& userCapVariables();

/// Returns the stricter of \a a and \a b in each respect, with the places of both.
UserCaps stricter(UserCaps a, const UserCaps& b);

/// Joins both texts of places.
std::string joinedPlaces(const std::string& a, const std::string& b);

} // namespace midair::device
