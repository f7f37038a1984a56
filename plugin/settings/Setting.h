#pragma once

#include <osgMidair/HapticSettings>

#include <osg/Matrixd>

#include <functional>
#include <limits>
#include <string>
#include <variant>
#include <vector>

namespace osgMidair
{

/// Member of enum type, of a struct \a T.
template<typename T>
struct Choice
{
    int (*get)(const T&);
    void (*set)(T&, int);
};

/// One word of an enum: as people write it, as files name it, and its value.
struct Word
{
    std::string text;
    std::string stored;
    int value;
};

/// Where a setting is kept in its struct \a T, and with that what kind it is of; texts and matrices
/// are a scene's only.
template<typename T>
struct Kinds
{
    using Member = std::variant<bool T::*, int T::*, double T::*, Choice<T>>;
};
template<>
struct Kinds<HapticSettings>
{
    using T = HapticSettings;
    using Member = std::
        variant<bool T::*, int T::*, double T::*, Choice<T>, std::string T::*, osg::Matrixd T::*>;
};
template<typename T>
using Member = typename Kinds<T>::Member;

/// Of numbers: low .. high, ends included; orZero: 0 as well. Never NaN nor infinity.
struct Range
{
    double low = 0.0;
    double high = std::numeric_limits<double>::infinity();
    bool orZero = false;

    bool holds(double value) const;
    std::string text() const; ///< "0 or 0.001 .. 1", "at least 0"
};

/// A row of the table: all that the kit says, reads and checks about one value of a plain struct \a
/// T. The default is what the struct's member begins with.
template<typename T>
struct Setting
{
    std::string name; ///< as options, tags and settings files spell it: "fieldRate"
    Member<T> member{};
    std::string help;        ///< one line: what it does
    int since = 1;           ///< version of the file format that it came with
    Range range{};           ///< of numbers
    std::string unit;        ///< of numbers; empty: none
    std::vector<Word> words; ///< of an enum

    std::string stored;    ///< name in files where that isn't the name with a capital
    std::string variable;  ///< environment variable behind "OSG_MIDAIR_"; empty: there is none
    bool isSafety = false; ///< a value that isn't understood silences the array
    /// What a file asks for with it is a wish that the user grants.
    std::optional<std::string> HapticWishes::*wish = nullptr;
    /// Reads texts that this alone understands; empty: by its kind.
    std::function<bool(T&, const std::string&)> parse;

    /// The name in files: "FieldRate".
    std::string storedName() const;

    /// Sets \a object's from text; false where it isn't understood. Numbers out of range are taken:
    /// see repair().
    bool assign(T& object, const std::string& text) const;
    /// What assign() understands, "a number, 0 .. 1".
    std::string expected() const;
    /// True, with a sentence in \a what, if \a object's was out of range, and is the default now.
    bool repair(T& object, std::string& what) const;

    /// What it may be: "1 .. 40000 Hz", "true, false", "surface, edges, vertices".
    std::string values() const;
    /// What it begins with, "1000"; empty texts are empty.
    std::string defaultText() const;
    /// help, values and default in one line.
    std::string summary() const;
};

/// The member that \a M points to, an enum.
template<auto M>
struct EnumMember;
template<typename T, typename E, E T::*M>
struct EnumMember<M>
{
    static int get(const T& object) { return static_cast<int>(object.*M); }
    static void set(T& object, int value) { object.*M = static_cast<E>(value); }
    static constexpr Choice<T> choice() { return {&get, &set}; }
};

/// Whether both are equal; numbers also where neither is one, so that a NaN that stays is no
/// change.
template<typename T>
bool isSame(const Member<T>& member, const T& a, const T& b);

} // namespace osgMidair
