//! Small expressions over named numbers: derived values and constraints.
//!
//! `+ - * / ^`, parentheses, the comparisons `< <= > >= == !=` (1 where they hold, else 0), `and`, `or`, and the
//! functions of [`FUNCTIONS`]. Powers bind tightest and to the right; -2^2 is -4. Comparisons do not chain.

use std::collections::BTreeMap;
use std::str::FromStr;

/// Functions by name and number of arguments.
pub const FUNCTIONS: [(&str, usize); 9] =
    [("sqrt", 1), ("exp", 1), ("log", 1), ("sin", 1), ("cos", 1), ("tan", 1), ("abs", 1), ("min", 2), ("max", 2)];

/// Deepest nesting that is read.
const MOST_DEPTH: usize = 64;
/// Longest text.
const MOST_BYTES: usize = 10_000;

/// An expression that has been read.
#[derive(Debug, Clone, PartialEq)]
pub struct Expression {
    text: String,
    root: Node,
}

#[derive(Debug, Clone, PartialEq)]
enum Node {
    Number(f64),
    Name(String),
    Negative(Box<Node>),
    Binary(Operator, Box<Node>, Box<Node>),
    Call(&'static str, Vec<Node>),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Operator {
    Or,
    And,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Equal,
    Unequal,
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
}

impl Operator {
    const SYMBOLS: [(&'static str, Self); 13] = [
        ("or", Self::Or),
        ("and", Self::And),
        ("<=", Self::LessEqual),
        (">=", Self::GreaterEqual),
        ("==", Self::Equal),
        ("!=", Self::Unequal),
        ("<", Self::Less),
        (">", Self::Greater),
        ("+", Self::Add),
        ("-", Self::Subtract),
        ("*", Self::Multiply),
        ("/", Self::Divide),
        ("^", Self::Power),
    ];

    fn binding(self) -> u8 {
        match self {
            Self::Or => 1,
            Self::And => 2,
            Self::Less | Self::LessEqual | Self::Greater | Self::GreaterEqual | Self::Equal | Self::Unequal => COMPARES,
            Self::Add | Self::Subtract => 4,
            Self::Multiply | Self::Divide => 5,
            Self::Power => 7,
        }
    }

    fn of(self, a: f64, b: f64) -> f64 {
        let truth = |holds: bool| f64::from(u8::from(holds));
        match self {
            Self::Or => truth(a != 0.0 || b != 0.0),
            Self::And => truth(a != 0.0 && b != 0.0),
            Self::Less => truth(a < b),
            Self::LessEqual => truth(a <= b),
            Self::Greater => truth(a > b),
            Self::GreaterEqual => truth(a >= b),
            Self::Equal => truth(a == b),
            Self::Unequal => truth(a != b),
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => a / b,
            Self::Power => a.powf(b),
        }
    }
}

/// Binding of comparisons.
const COMPARES: u8 = 3;
/// Binding of a minus before a value: tighter than products, looser than powers.
const NEGATIVE: u8 = 6;

#[derive(Debug, Clone, PartialEq)]
enum Token {
    Number(f64),
    Name(String),
    Operator(Operator),
    Open,
    Close,
    Comma,
}

fn tokens(text: &str) -> Result<Vec<Token>, String> {
    let mut found = Vec::new();
    let mut rest = text.trim_start();
    while let Some(first) = rest.chars().next() {
        let taken = if first.is_ascii_digit() || first == '.' {
            let (number, length) = number(rest)?;
            found.push(Token::Number(number));
            length
        } else if first.is_alphabetic() || first == '_' {
            let length = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
            let word = &rest[..length];
            found.push(match Operator::SYMBOLS.iter().find(|(symbol, _)| *symbol == word) {
                Some((_, operator)) => Token::Operator(*operator),
                None => Token::Name(word.to_owned()),
            });
            length
        } else if let Some((symbol, operator)) = Operator::SYMBOLS.iter().find(|(symbol, _)| rest.starts_with(symbol)) {
            found.push(Token::Operator(*operator));
            symbol.len()
        } else {
            found.push(match first {
                '(' => Token::Open,
                ')' => Token::Close,
                ',' => Token::Comma,
                other => return Err(format!("{other:?} has no meaning in an expression")),
            });
            1
        };
        rest = rest[taken..].trim_start();
    }
    Ok(found)
}

/// A number at the start of a text, and its length.
fn number(text: &str) -> Result<(f64, usize), String> {
    let bytes = text.as_bytes();
    let digits = |from: usize| from + bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
    let mut end = digits(0);
    if bytes.get(end) == Some(&b'.') {
        end = digits(end + 1);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let after = digits(end + 1 + sign);
        if after > end + 1 + sign {
            end = after;
        }
    }
    match text[..end].parse::<f64>() {
        Ok(number) if number.is_finite() => Ok((number, end)),
        _ => Err(format!("{:?} is no number", &text[..end])),
    }
}

struct Parser {
    tokens: std::iter::Peekable<std::vec::IntoIter<Token>>,
}

impl Parser {
    /// Operators that bind at least so tightly.
    fn binding_at_least(&mut self, least: u8, depth: usize) -> Result<Node, String> {
        if depth > MOST_DEPTH {
            return Err(format!("is nested deeper than {MOST_DEPTH} times"));
        }
        let mut left = match self.tokens.next() {
            Some(Token::Number(number)) => Node::Number(number),
            Some(Token::Name(name)) => self.named(name, depth)?,
            Some(Token::Operator(Operator::Subtract)) => {
                Node::Negative(Box::new(self.binding_at_least(NEGATIVE, depth + 1)?))
            }
            Some(Token::Open) => {
                let inner = self.binding_at_least(0, depth + 1)?;
                self.close()?;
                inner
            }
            Some(_) => return Err("has an operator, a comma or a bracket where a value should be".into()),
            None => return Err("ends where a value should be".into()),
        };
        let mut compared = false;
        while let Some(Token::Operator(operator)) = self.tokens.peek() {
            let operator = *operator;
            if operator.binding() < least {
                break;
            }
            // 1 < a < 2 would be (1 < a) < 2, which always holds.
            if compared && operator.binding() == COMPARES {
                return Err("compares three values at once; write a < b and b < c".into());
            }
            compared = operator.binding() == COMPARES;
            self.tokens.next();
            // Powers go to the right, all else to the left.
            let next = operator.binding() + u8::from(operator != Operator::Power);
            let right = self.binding_at_least(next, depth + 1)?;
            left = Node::Binary(operator, Box::new(left), Box::new(right));
        }
        Ok(left)
    }

    fn named(&mut self, name: String, depth: usize) -> Result<Node, String> {
        if self.tokens.peek() != Some(&Token::Open) {
            return Ok(Node::Name(name));
        }
        let known = FUNCTIONS.iter().find(|(known, _)| *known == name);
        let Some((function, count)) = known else {
            let all: Vec<&str> = FUNCTIONS.iter().map(|(known, _)| *known).collect();
            return Err(format!("{name} is no function; there are {}", all.join(", ")));
        };
        self.tokens.next();
        let mut arguments = vec![self.binding_at_least(0, depth + 1)?];
        while self.tokens.next_if_eq(&Token::Comma).is_some() {
            arguments.push(self.binding_at_least(0, depth + 1)?);
        }
        self.close()?;
        match arguments.len() == *count {
            true => Ok(Node::Call(function, arguments)),
            false => Err(format!("{function} takes {count} values, has {}", arguments.len())),
        }
    }

    fn close(&mut self) -> Result<(), String> {
        match self.tokens.next() {
            Some(Token::Close) => Ok(()),
            _ => Err("lacks a closing bracket".into()),
        }
    }
}

impl FromStr for Expression {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.len() > MOST_BYTES {
            return Err(format!("is longer than {MOST_BYTES} bytes"));
        }
        let mut parser = Parser { tokens: tokens(text)?.into_iter().peekable() };
        let root = parser.binding_at_least(0, 0)?;
        match parser.tokens.next() {
            None => Ok(Self { text: text.trim().to_owned(), root }),
            Some(_) => Err("goes on where it should end".into()),
        }
    }
}

impl std::fmt::Display for Expression {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.text)
    }
}

impl Expression {
    /// The names in it.
    pub fn names(&self) -> Vec<&str> {
        fn walk<'n>(node: &'n Node, found: &mut Vec<&'n str>) {
            match node {
                Node::Number(_) => {}
                Node::Name(name) => found.push(name),
                Node::Negative(inner) => walk(inner, found),
                Node::Binary(_, left, right) => {
                    walk(left, found);
                    walk(right, found);
                }
                Node::Call(_, arguments) => arguments.iter().for_each(|argument| walk(argument, found)),
            }
        }
        let mut found = Vec::new();
        walk(&self.root, &mut found);
        found
    }

    /// Its value where names have these.
    ///
    /// # Errors
    /// A name that has no value, a part that is no number (the root of less than 0), or a result that is not finite.
    pub fn value(&self, names: &BTreeMap<&str, f64>) -> Result<f64, String> {
        fn of(node: &Node, names: &BTreeMap<&str, f64>) -> Result<f64, String> {
            let value = match node {
                Node::Number(number) => *number,
                Node::Name(name) => {
                    *names.get(name.as_str()).ok_or_else(|| format!("{name} has no numerical value here"))?
                }
                Node::Negative(inner) => -of(inner, names)?,
                Node::Binary(operator, left, right) => operator.of(of(left, names)?, of(right, names)?),
                Node::Call(function, arguments) => {
                    let values = arguments.iter().map(|one| of(one, names)).collect::<Result<Vec<_>, _>>()?;
                    match (*function, values.as_slice()) {
                        ("sqrt", [x]) => x.sqrt(),
                        ("exp", [x]) => x.exp(),
                        ("log", [x]) => x.ln(),
                        ("sin", [x]) => x.sin(),
                        ("cos", [x]) => x.cos(),
                        ("tan", [x]) => x.tan(),
                        ("abs", [x]) => x.abs(),
                        ("min", [x, y]) => x.min(*y),
                        ("max", [x, y]) => x.max(*y),
                        _ => return Err(format!("{function} is no function")),
                    }
                }
            };
            // Least and largest values, and truths, would let it pass.
            if value.is_nan() { Err("has a part that is NaN here".into()) } else { Ok(value) }
        }
        let value = of(&self.root, names)?;
        match value.is_finite() {
            true => Ok(value),
            false => Err(format!("{} is {value} here", self.text)),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn value(text: &str) -> Result<f64, String> {
        text.parse::<Expression>()?.value(&BTreeMap::from([("n_top", 1.42), ("d", 8.0)]))
    }

    #[test]
    fn arithmetic_is_that_of_paper() {
        for (text, expected) in [
            ("n_top - 0.01", 1.42 - 0.01),
            ("1 - 2 - 3", -4.0),
            ("8 / 4 / 2", 1.0),
            ("2 ^ 3 ^ 2", 512.0),
            ("-2^2", -4.0),
            ("2 ^ -1", 0.5),
            ("-d * -2", 16.0),
            ("1 + 2 * 3 - 4", 3.0),
            ("(1 + 2) * 3", 9.0),
            ("max(1, min(d, 3))", 3.0),
            ("sqrt(d * 2) + exp(0) + log(1) + abs(-1)", 6.0),
            ("1.5e1 + .5", 15.5),
            ("2e", f64::NAN),
            ("1 < d < 3", f64::NAN),
            ("d == 8 == 1", f64::NAN),
            ("1 < d + 1 > 3", f64::NAN),
            ("(1 < d) < 3", 1.0),
            ("1 < d and d < 9 or d < 0", 1.0),
            ("min(1, sqrt(-d))", f64::NAN),
            ("sqrt(-d) or 1 < d", f64::NAN),
            ("log(-d) < 5 or d > 1", f64::NAN),
            ("max(1, 1 / 0) > 2", 1.0),
        ] {
            match value(text) {
                Ok(found) => assert_eq!(found, expected, "{text}"),
                Err(_) => assert!(expected.is_nan(), "{text}"),
            }
        }
    }

    #[test]
    fn comparisons_are_1_or_0() {
        for (text, expected) in
            [("d < 9", 1.0), ("d >= 9 or n_top > 1.4", 1.0), ("d <= 9 and n_top == 1", 0.0), ("1 + 1 != 2", 0.0)]
        {
            assert_eq!(value(text).unwrap(), expected, "{text}");
        }
    }

    #[test]
    fn mistakes_are_told() {
        for (text, said) in [
            ("", "ends where a value should be"),
            ("1 +", "ends where a value should be"),
            ("1 2", "goes on"),
            ("(1", "lacks a closing bracket"),
            ("foo(1)", "foo is no function"),
            ("min(1)", "min takes 2 values, has 1"),
            ("1 $ 2", "'$' has no meaning"),
            ("* 2", "where a value should be"),
            ("depth", "depth has no numerical value"),
            ("1 / 0", "is inf"),
            ("sqrt(-1)", "is NaN"),
        ] {
            let found = value(text).unwrap_err();
            assert!(found.contains(said), "{text}: {found}");
        }
        assert!(value(&"(".repeat(1000)).unwrap_err().contains("nested"));
        assert!(value(&"-".repeat(1000)).unwrap_err().contains("nested"));
    }

    #[test]
    fn names_are_found() {
        assert_eq!("max(a, b * 2) - a".parse::<Expression>().unwrap().names(), ["a", "b", "a"]);
    }

    proptest! {
        #[test]
        fn no_text_makes_the_reader_panic(text in "[-+*/^()<>=!., 0-9a-z_é$]{0,60}") {
            let _ = value(&text);
        }
    }
}
