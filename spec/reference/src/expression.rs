//! Expressions and forms.

use crate::agent::{Agent, Said};
use crate::program::{Expr, Form, Relation, Term};
use crate::task::{Level, Work};
use crate::trace::What;
use crate::value::{Value, phrase};

/// The expression has no value; the reason is not needed here.
#[derive(Debug)]
pub(crate) struct Fails;

pub(crate) fn compare(relation: Relation, left: &Value, right: &Value) -> Result<bool, Fails> {
    let order = match (left, right) {
        (Value::Number(a), Value::Number(b)) => a.partial_cmp(b).ok_or(Fails)?,
        (Value::Span(a), Value::Span(b)) => a.cmp(b),
        _ if relation == Relation::Equal => return Ok(left == right),
        _ => return Err(Fails),
    };
    Ok(match relation {
        Relation::Equal => order.is_eq(),
        Relation::Less => order.is_lt(),
        Relation::AtMost => order.is_le(),
        Relation::More => order.is_gt(),
        Relation::AtLeast => order.is_ge(),
    })
}

impl Agent<'_> {
    pub(crate) fn evaluate(&self, expr: &Expr, task: usize, level: Level) -> Result<Value, Fails> {
        let value = |expr| self.evaluate(expr, task, level);
        Ok(match expr {
            Expr::Is(value) => value.clone(),
            Expr::Variable(name) => self.variable(task, level, name).ok_or(Fails)?,
            Expr::Sum(a, b) => match (value(a)?, value(b)?) {
                (Value::Number(a), Value::Number(b)) => Value::Number(a + b),
                (Value::Span(a), Value::Span(b)) => Value::Span(a + b),
                _ => return Err(Fails),
            },
            Expr::Difference(a, b) => match (value(a)?, value(b)?) {
                (Value::Number(a), Value::Number(b)) => Value::Number(a - b),
                (Value::Span(a), Value::Span(b)) => Value::Span(a - b),
                _ => return Err(Fails),
            },
            Expr::Compare(relation, a, b) => Value::truth(compare(*relation, &value(a)?, &value(b)?)?),
            Expr::If(test, a, b) => {
                if value(test)?.is_true() {
                    value(a)?
                } else {
                    value(b)?
                }
            }
            Expr::Current(attribute, object) => self.newest(attribute, object).unwrap_or(Value::Nil),
            Expr::MissionTime => Value::Span(self.now),
            Expr::StateOf(tag) => match self.variable(task, level, tag) {
                Some(Value::Task(other)) if !self.tasks[other].forgotten => Value::word(self.tasks[other].state.word()),
                _ => return Err(Fails),
            },
            Expr::First(list) => match value(list)? {
                Value::List(items) => items.first().cloned().unwrap_or(Value::Nil),
                Value::Nil => Value::Nil,
                _ => return Err(Fails),
            },
        })
    }

    /// Returns a phrase with its variables filled in.
    pub(crate) fn filled(&self, phrase: &[Term], task: usize, level: Level) -> Result<Vec<Value>, Fails> {
        phrase.iter().map(|term| self.word(term, task, level)).collect()
    }

    pub(crate) fn word(&self, term: &Term, task: usize, level: Level) -> Result<Value, Fails> {
        match term {
            Term::Is(value) => Ok(value.clone()),
            Term::Variable(name) => self.variable(task, level, name).ok_or(Fails),
            Term::Anything => Err(Fails),
        }
    }

    /// Runs forms in sequence. Returns the argument of `complete`, if it was called.
    pub(crate) fn run_forms(&mut self, task: usize, level: Level, forms: &[Form]) -> Result<Option<Value>, Fails> {
        let mut completed = None;
        for form in forms {
            self.run_form(task, level, form, &mut completed)?;
        }
        Ok(completed)
    }

    fn run_form(&mut self, task: usize, level: Level, form: &Form, completed: &mut Option<Value>) -> Result<(), Fails> {
        match form {
            Form::Inform(words) => {
                let words = self.filled(words, task, level)?;
                self.inform(task, words);
            }
            Form::Print(expr) => {
                let text = self.evaluate(expr, task, level)?.to_string();
                self.tell(task, What::Printed(text));
            }
            Form::Publish(attribute, object, expr) => {
                let value = self.evaluate(expr, task, level)?;
                self.said.push(Said::Sample(attribute.clone(), object.clone(), value));
            }
            Form::Complete(expr) => {
                let value = expr.as_ref().map_or(Ok(Value::Nil), |expr| self.evaluate(expr, task, level))?;
                *completed = Some(value);
            }
            Form::When(test, form) => {
                if self.evaluate(test, task, level)?.is_true() {
                    self.run_form(task, level, form, completed)?;
                }
            }
            Form::Set(name, expr) => {
                let value = self.evaluate(expr, task, level)?;
                match &mut self.tasks[task].work {
                    Some(Work::Primitive { locals, .. }) if locals.contains_key(name) => {
                        locals.insert(name.clone(), value);
                    }
                    _ => self.assign(task, level, name, value),
                }
            }
        }
        Ok(())
    }

    /// `(inform PHRASE)`: for the world, and for the agent itself.
    pub(crate) fn inform(&mut self, task: usize, words: Vec<Value>) {
        self.tell(task, What::Informed(phrase(&words)));
        self.said.push(Said::Message(words));
    }
}
