// Sentences of the language's definition, one small model each: the strings of all steps, the same in Espalier's own
// numbers and in the compatible mode.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/derived_model.h"

namespace espalier::language_sentences_test {
namespace {

struct Sentence {
  const char* claim;
  std::string model;
  std::vector<std::string> strings;  // of the steps 0, 1, ...
};

void PrintTo(const Sentence& sentence, std::ostream* stream) {
  *stream << sentence.claim;
}

/// "Lsystem: 1 / derivation length: 9 / ITEMS Axiom: AXIOM / PRODUCTIONS endlsystem".
std::string model(const std::string& items, const std::string& axiom, const std::string& productions) {
  return "Lsystem: 1\nderivation length: 9\n" + items + "Axiom: " + axiom + "\n" + productions + "endlsystem\n";
}

class LanguageSentence : public testing::TestWithParam<Sentence> {};

TEST_P(LanguageSentence, Holds) {
  for (const core::Compatibility mode : {core::Compatibility::Espalier, core::Compatibility::Cpfg}) {
    test::DerivedModel run(GetParam().model, {}, mode);
    EXPECT_EQ(run.text(), GetParam().strings.front()) << GetParam().claim;
    for (std::size_t step = 1; step < GetParam().strings.size(); ++step) {
      EXPECT_EQ(run.steps(1), GetParam().strings[step]) << GetParam().claim << ", step " << step;
    }
  }
}

const std::vector<Sentence> kLexing = {
    {"quotes, primes and backslashes are symbols",
     model("", "A\"B'\\C", "A --> \"A\n\" --> x\n' --> y\n\\ --> z\n"),
     {"A\"B'\\C", "\"AxByzC"}},
    {"# is a symbol where it is not first on its line", model("", "#(2)", "* < #(w) --> #(w+1)\n"), {"#(2)", "#(3)"}},
    {"a macro replaces whole words of a string only",
     "#define A B\n" + model("", "ACC A C", "C --> D A\nB --> E\n"),
     {"ACCBC", "ADBDBEDB"}},
    {"a function-like macro without arguments is no macro",
     "#define f(x) x x\n" + model("", "f f(A)", "A --> B\n"),
     {"fAA", "fBB"}},
    {"blanks may stand between a symbol and its parameters",
     model("", "A ( 1 , 2 ) B", "A ( x , y ) --> B ( x + y )\n"),
     {"A(1,2)B", "B(3)B"}},
    {"a line that starts with a TAB continues any item",
     model("", "A(1,\n\t2)\n\tB", "A(x,\n\ty) :\n\tx>0 -->\n\tC(x+\n\ty)\n"),
     {"A(1,2)B", "C(3)B"}},
    {"lines of blanks and TABs are nothing",
     model("\n\t\n  \n", "A", "\n\t\nA --> B\n \n\t\nB --> A\n"),
     {"A", "B", "A"}},
    {"no blanks are needed anywhere",
     "Lsystem:1\nderivation length:9\nAxiom:A(1)B\nA(x):x>0-->B(x)\nB-->C\nendlsystem",
     {"A(1)B", "B(1)C"}},
    {"a leading underscore is dropped",
     model("Start: {y=3;}\n", "A(_y)", "A(x) --> B(x,_y,y)\n"),
     {"A(3)", "B(3,3,3)"}},
    {"labels are numbers as atof reads them",
     "Lsystem: plant\nderivation length: 9\nAxiom: ?(2)A$A\nx --> x\nendlsystem\n"
     "Lsystem: 2.7\nAxiom: X\nA --> B\nendlsystem\n",
     {"?(2)A$A", "?(2)B$A"}},
};

const std::vector<Sentence> kExpressions = {
    {"operators",
     model("", "A(2<>3)B(--1)C(2--1)D(!0)E(!!5)F(-2^2)G(2^-1)H(7%4%2)I(-7%3)J(7.9%2.9)K(2^3^2)", "x --> x\n"),
     {"A(1)B(1)C(3)D(1)E(1)F(4)G(0.5)H(1)I(-1)J(1)K(64)"}},
    {"a division by 0 divides by 1", model("", "A(7%0)B(3/0)", "x --> x\n"), {"A(0)B(3)"}},
    {"? : in conditions and successors",
     model("", "A(1)", "A(x) : x>0 ? 0 : 1 --> B\nA(x) : 1 --> C(x>0 ? x>1 ? 3 : 4 : 5)\n"),
     {"A(1)", "C(4)"}},
    {"arrays without values are 0, subscripts are truncated and clamped",
     model("define: {array a[2][3]={1,2,3,4}, b[2];}\nStartEach: {b[0]=b[0]+1;}\n", "A",
           "A --> A(a[0][2],a[1][0],a[1][1],b[0],a[5][-3],a[0.9][1.9])\n"),
     {"A", "A(3,4,0,1,4,2)"}},
    {"loops and branches of blocks",
     model("Start: {i=0; do {i=i+1; if (i>3) {j=i;} else {if (i==2) {k=5;}}} while (i<5); while (i>2) {i=i-1;}}\n",
           "A(i,j,k)", "x --> x\n"),
     {"A(2,5,5)"}},
    {"SetDerivationLength changes Z",
     model("Start: {SetDerivationLength(4);}\n", "A", "A --> A(Z,GetDerivationLength(0))\n"),
     {"A", "A(4,4)"}},
    {"StartEach sees the new Q and EndEach follows the scan",
     model("StartEach: {s=Q;}\nEndEach: {e=Q;}\n", "A(s,e)", "A(x,y) --> A(s,e)\n"),
     {"A(0,0)", "A(1,0)", "A(2,1)"}},
};

const std::vector<Sentence> kVariables = {
    {"of equal formal names left context, predecessor, right context count in this order",
     model("", "B(5)A(1)C(2)", "B(x) < A(x) > C(x) --> A(x)\nA(x) > C(x) --> D(x)\n"),
     {"B(5)A(1)C(2)", "B(5)A(5)C(2)"}},
    {"the predecessor's formal name counts before the right context's",
     model("", "A(1)B(2)", "A(x) > B(x) --> D(x)\n"),
     {"A(1)B(2)", "D(1)B(2)"}},
    {"a variable that only a production assigns is its own and keeps its value",
     model("", "AB", "A : {x=x+1;} 1 --> A(x)\nA(y) : {x=x+5;} 1 --> A(x)\nB : 1 {x=x+10;} --> CB\nC --> C(x)\n"),
     {"AB", "A(1)CB", "A(5)C(0)CB", "A(10)C(0)C(0)CB"}},
    {"a post-block may change a formal parameter",
     model("", "A(0)", "A(t) : t<2 {x=t*2; t=t+1;} --> A(t)B(x)\n"),
     {"A(0)", "A(1)B(0)", "A(2)B(2)B(0)"}},
};

const std::vector<Sentence> kContexts = {
    {"a symbol that ignore names is ignored though consider names it",
     model("consider: AB\nignore: B\n", "AXBXA", "A < A --> Y\n"),
     {"AXBXA", "AXBXY"}},
    {"= skips to the end of the branch",
     model("", "A[B[C]D]EA[CB]E", "A > [B=]E --> X\n"),
     {"A[B[C]D]EA[CB]E", "X[B[C]D]EA[CB]E"}},
    {"= may be followed by ] alone", model("", "J[BC]J[CB]", "J > [B=] --> X\n"), {"J[BC]J[CB]", "X[BC]J[CB]"}},
    {"branches in branches of a right context", model("", "S[[B]A]C", "S > [[B]A]C --> X\n"), {"S[[B]A]C", "X[[B]A]C"}},
    {"ignored symbols are skipped inside the brackets of a context",
     model("ignore: +-\n", "A+[-B+C]-D", "A > [B=]D --> X\n"),
     {"A+[-B+C]-D", "X+[-B+C]-D"}},
    {"brackets that consider does not list are never found",
     model("consider: AB\n", "A[xB]A", "A > [B] --> X\nA > B --> Y\n"),
     {"A[xB]A", "Y[xB]A"}},
    {"a ring's module is its own neighbour when it is alone",
     model("Ring Lsystem\n", "A", "A < A --> B\n"),
     {"A", "B"}},
    {"a predecessor does not go round a ring",
     model("Ring Lsystem\n", "CAB", "BC --> X\nC > A --> D\n"),
     {"CAB", "DAB"}},
    {"ignored symbols at the ends of a ring",
     model("Ring Lsystem\nignore: +\n", "+A+B+", "B < A --> X\nA < B > A --> Y\n"),
     {"+A+B+", "+X+Y+"}},
};

const std::vector<Sentence> kCut = {
    {"the axiom's cut counts in step 1",
     model("", "A[%B]C%D", "B --> BB\nC --> CC\n"),
     {"A[%B]C%D", "A[]CC", "A[]CCCC"}},
    {"% in a predecessor is rewritten, not obeyed",
     model("", "AB%CD", "B% --> X\nD --> DD\n"),
     {"AB%CD", "AXCDD", "AXCDDDD"}},
    {"% is a context like any symbol", model("", "AB%CD", "B > % --> X\n"), {"AB%CD", "AX"}},
    {"a decomposition may replace %",
     model("", "A", "A --> B%C\ndecomposition\nmaximum depth: 2\nB --> DE\n% --> F\n"),
     {"A", "DEFC", "DEFC"}},
    {"%(p) keeps what it cuts at the end of the string",
     model("", "A", "A --> B[%(3)CD]E\n"),
     {"A", "B[%(3)CD]E", "B[]E%(3,0)CD", "B[]E%(3,0)CD"}},
};

const std::vector<Sentence> kSections = {
    {"a section may have its colon, its depth and its warnings",
     model("", "A",
           "A --> AB\nDecomposition: no warnings\nmaximum depth: 2\nB --> CB\nHomomorphism: no warnings\nmaximum "
           "depth: 2\nC --> F\n"),
     {"A", "ACCB", "ACCBCCCCB"}},
    {"the default depth of a decomposition is 1",
     model("", "A", "A --> B\ndecomposition no warnings\nB --> C\nC --> D\n"),
     {"A", "C", "D"}},
    {"a context that is a star is none", model("", "AB", "* < A > * : * --> C\n* < B --> D\n"), {"AB", "CD"}},
    {"stop ends the derivation after its step and End runs",
     model("End: {x=100;}\n", "A(0,x)", "A(n,y) : 1 {if (n==1) {stop(2);}} --> A(n+1,x)\n"),
     {"A(0,0)", "A(1,0)", "A(2,0)"}},
};

INSTANTIATE_TEST_SUITE_P(Lexing, LanguageSentence, testing::ValuesIn(kLexing));
INSTANTIATE_TEST_SUITE_P(Expressions, LanguageSentence, testing::ValuesIn(kExpressions));
INSTANTIATE_TEST_SUITE_P(Variables, LanguageSentence, testing::ValuesIn(kVariables));
INSTANTIATE_TEST_SUITE_P(Contexts, LanguageSentence, testing::ValuesIn(kContexts));
INSTANTIATE_TEST_SUITE_P(Cut, LanguageSentence, testing::ValuesIn(kCut));
INSTANTIATE_TEST_SUITE_P(Sections, LanguageSentence, testing::ValuesIn(kSections));

}  // namespace
}  // namespace espalier::language_sentences_test
