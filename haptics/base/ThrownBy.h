#pragma once

#include <exception>
#include <string>

namespace midair::base
{

/// To be called in a handler of all exceptions: what was caught, in words. Code of an application
/// may throw whatever it likes, and what no handler takes ends the program.
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

/// Calls \a call, which runs code of an application, and catches whatever it throws. Returns that
/// in words, with which a sentence goes on ("has thrown ..."); empty if it returned.
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
        return "what is no std::exception";
    }
}

} // namespace midair::base
