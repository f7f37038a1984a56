#pragma once

#include <exception>
#include <string>

namespace midair::base
{

/// Describes the exception being handled; call it in a catch-all handler. Application code may
/// throw anything, and an unhandled exception ends the program.
inline std::string whatWasThrown()
{
    try
    {
        throw;
    }
    catch (const std::exception& error)
    {
        return error.what();
    }
    catch (...)
    {
        return "something was thrown that is no std::exception";
    }
}

/// Calls \a call, which runs application code, and catches every exception. Returns it as a phrase
/// ("has thrown ..."), or an empty text if the call returned.
template<typename Call>
std::string thrownBy(const Call& call)
{
    try
    {
        call();
        return {};
    }
    catch (const std::exception& error)
    {
        return '"' + std::string(error.what()) + '"';
    }
    catch (...)
    {
        return "an exception that is no std::exception";
    }
}

} // namespace midair::base
